#include <cmath>
#include <stdexcept>

#include "condition/condition.h"

namespace vildar {
namespace {

/// Power equal to time, so that means are known: 1 kHz from 0 to 1 s, without the samples in [from,
/// to).
PowerTrace ramp(double gap_from_s, double gap_to_s) {
  PowerTrace trace;
  trace.sample_period_s = 1e-3;
  trace.noise_sigma_w = 0.2;
  for (int k = 0; k < 1000; ++k) {
    const double time_s = k * 1e-3;
    if (time_s > gap_from_s - 1e-9 && time_s < gap_to_s - 1e-9) continue;
    trace.time_s.push_back(time_s);
    trace.power_w.push_back(static_cast<float>(time_s));
  }
  return trace;
}

TEST(BlockMeans, AreTheMeansOfTheirSamplesAtTheirMiddle) {
  const std::vector<PowerBlock> blocks = block_means(ramp(2, 2), 0.1, 0.9, 0.05);
  ASSERT_EQ(blocks.size(), 16U);
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    const double middle_s =
        0.1 + 0.05 * static_cast<double>(k) + 0.0245;  // samples 0 to 49 of the block
    EXPECT_EQ(blocks[k].samples, 50);
    EXPECT_NEAR(blocks[k].time_s, middle_s, 1e-9);
    EXPECT_NEAR(blocks[k].power_w, middle_s, 1e-6);  // samples are floats
    EXPECT_NEAR(blocks[k].duration_s, 0.05, 1e-12);
    EXPECT_NEAR(blocks[k].sigma_w, 0.2 / std::sqrt(50.0), 1e-12);
  }
}

TEST(BlockMeans, GapsShortenOrDropTheBlocksTheyTouch) {
  // Blocks of 100 ms: the gap leaves 70 ms of block 2, none of block 3, 30 ms of block 4.
  const std::vector<PowerBlock> blocks = block_means(ramp(0.27, 0.47), 0.0, 1.0, 0.1);
  ASSERT_EQ(blocks.size(), 8U);
  EXPECT_EQ(blocks[2].samples, 70);
  EXPECT_NEAR(blocks[2].duration_s, 0.07, 1e-12);
  EXPECT_NEAR(blocks[2].time_s, 0.2345, 1e-9);
  EXPECT_NEAR(blocks[3].time_s, 0.5495, 1e-9);
}

TEST(BlockMeans, OfABlockBrokenInTheMiddleTheLongerPartIsUsed) {
  const std::vector<PowerBlock> blocks = block_means(ramp(0.03, 0.04), 0.0, 0.1, 0.1);
  ASSERT_EQ(blocks.size(), 1U);
  EXPECT_EQ(blocks[0].samples, 60);
  EXPECT_NEAR(blocks[0].power_w, 0.0695, 1e-6);
}

TEST(BlockMeans, OneLostSampleIsNoGap) {
  const std::vector<PowerBlock> blocks = block_means(ramp(0.05, 0.051), 0.0, 0.1, 0.1);
  ASSERT_EQ(blocks.size(), 1U);
  EXPECT_EQ(blocks[0].samples, 99);
}

TEST(BlockMeans, BlocksShorterThanTheSpacingHoldOneSampleEach) {
  EXPECT_EQ(block_means(ramp(2, 2), 0.0, 1.0, 1e-4).size(), 1000U);
}

TEST(BlockMeans, RefusesBlocksWithoutLength) {
  const PowerTrace trace = ramp(2, 2);
  EXPECT_THROW(block_means(trace, 0.0, 1.0, 0.0), std::invalid_argument);
  EXPECT_THROW(block_means(trace, 1.0, 0.0, 0.1), std::invalid_argument);
  EXPECT_THROW(block_means(trace, 0.0, std::nan(""), 0.1), std::invalid_argument);
  EXPECT_TRUE(block_means(trace, 5.0, 6.0, 0.1).empty());
  EXPECT_TRUE(block_means(PowerTrace{}, 0.0, 1.0, 0.1).empty());
}

}  // namespace
}  // namespace vildar
