#include "estimate/light_edges.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/random.h"

namespace vildar {
namespace {

constexpr double kBlock_s = 0.01, kSigma_w = 1e-3, kAmbient_w = 0.2;

// `light_w` by block, some noise.
template <typename Light>
std::vector<PowerBlock> blocks_of(int count, Light light_w) {
  Random random(3);
  std::vector<PowerBlock> blocks;
  for (int i = 0; i < count; ++i) {
    PowerBlock block;
    block.time_s = i * kBlock_s;
    block.duration_s = kBlock_s;
    block.power_w = kAmbient_w + light_w(i) + kSigma_w * random.normal();
    block.sigma_w = kSigma_w;
    blocks.push_back(block);
  }
  return blocks;
}

// A hyperbola of the scale that the closest and fastest vehicles have.
TEST(LightEdges, ASmoothPulseStaysWhole) {
  for (const double scale_blocks : {3.0, 8.0, 40.0}) {
    auto blocks = blocks_of(
        200, [&](int i) { return 1.0 / (1.0 + std::pow((i - 120.3) / scale_blocks, 2)); });
    keep_between_edges(blocks, kAmbient_w);
    EXPECT_EQ(blocks.size(), 200u) << scale_blocks;
  }
}

TEST(LightEdges, LightIsKeptUpToWhereItVanishes) {
  constexpr int kLit = 120;
  for (const double share : {0.0, 0.3, 0.8, 1.0}) {  // of the block in which it vanishes
    auto blocks = blocks_of(200, [&](int i) {
      const double light_w = std::pow((i + 10.0) / kLit, 2);
      return i < kLit ? light_w : i == kLit ? share * light_w : 0.0;
    });
    keep_between_edges(blocks, kAmbient_w);
    ASSERT_FALSE(blocks.empty());
    EXPECT_EQ(blocks.front().time_s, 0.0);
    EXPECT_LE(blocks.back().time_s, (kLit - 1) * kBlock_s) << share;
    EXPECT_GE(blocks.back().time_s, (kLit - 4) * kBlock_s) << share;
  }
}

TEST(LightEdges, OfLightThatAMaskLetsInAndOutTheBrightestStretchIsKept) {
  auto blocks = blocks_of(200, [](int i) { return i < 50 ? 0.02 : i < 150 ? 0.5 : 0.1; });
  keep_between_edges(blocks, kAmbient_w);
  ASSERT_FALSE(blocks.empty());
  EXPECT_NEAR(blocks.front().time_s, 50 * kBlock_s, 2.5 * kBlock_s);
  EXPECT_NEAR(blocks.back().time_s, 149 * kBlock_s, 2.5 * kBlock_s);
}

// What happened where samples are missing is not known.
TEST(LightEdges, AGapIsNoEdge) {
  auto blocks = blocks_of(200, [](int i) { return std::pow((i + 10.0) / 200.0, 2); });
  blocks.erase(blocks.begin() + 120, blocks.begin() + 160);
  keep_between_edges(blocks, kAmbient_w);
  EXPECT_EQ(blocks.size(), 160u);
}

// The rise within blocks of 8 samples hides that the light falls from one sample to the next.
TEST(LightEdges, SamplesTellWhatLongBlocksHide) {
  constexpr int kSamples = 640, kEach = 8;
  for (int lit = 560; lit < 560 + kEach; ++lit) {
    const auto light_w = [lit](int k) {
      return k < lit ? 1.0 / (1.0 + std::pow((k - 570) / 16.0, 2)) : 0.0;
    };
    const auto samples = blocks_of(kSamples, light_w);
    std::vector<PowerBlock> blocks;
    for (int i = 0; i < kSamples; i += kEach) {
      PowerBlock block{(i + 0.5 * (kEach - 1)) * kBlock_s, kEach * kBlock_s, 0.0,
                       kSigma_w / std::sqrt(kEach), kEach};
      for (int k = i; k < i + kEach; ++k)
        block.power_w += samples[static_cast<std::size_t>(k)].power_w / kEach;
      blocks.push_back(block);
    }
    keep_between_edges(blocks, kAmbient_w, samples);
    ASSERT_FALSE(blocks.empty());
    EXPECT_LE(blocks.back().time_s, lit * kBlock_s) << lit;
    EXPECT_GE(blocks.back().time_s, (lit - 4 * kEach) * kBlock_s) << lit;
  }
}

// As far below the block before as the rise of three blocks.
TEST(LightEdges, ALastBlockWithinAnEdgeGoes) {
  for (const double share : {0.95, 0.955, 0.96}) {
    auto blocks = blocks_of(100, [&](int i) { return (i < 99 ? 1.0 : share) * (0.5 + 0.012 * i); });
    keep_between_edges(blocks, kAmbient_w);
    EXPECT_EQ(blocks.back().time_s, 98 * kBlock_s) << share;
  }
}

}  // namespace
}  // namespace vildar
