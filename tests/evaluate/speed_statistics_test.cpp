#include "evaluate/speed_statistics.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/random.h"

namespace vildar {
namespace {

constexpr double kRounding = 1e-9;

SpeedPair pair_kmh(double true_kmh, double error_kmh) {
  const double stated_mps = (true_kmh + error_kmh) / 3.6;
  return {{0.0, stated_mps, 0.5, stated_mps - 1.0, stated_mps + 1.0}, true_kmh / 3.6};
}

TEST(SpeedStatistics, AreThoseWorkedOutByHand) {
  // Errors -1, +2, -2.5, +4, +10 km/h at 50 km/h; absolute and sorted 1 2 2.5 4 10.
  std::vector<SpeedPair> pairs;
  for (const double error_kmh : {-1.0, 2.0, -2.5, 4.0, 10.0})
    pairs.push_back(pair_kmh(50.0, error_kmh));
  const SpeedStatistics speed = speed_statistics(pairs);
  EXPECT_EQ(speed.count, 5U);
  EXPECT_NEAR(*speed.kmh.mean_abs, 3.9, kRounding);
  EXPECT_NEAR(*speed.kmh.median_abs, 2.5, kRounding);
  EXPECT_NEAR(*speed.kmh.p95_abs, 4.0 + 0.8 * 6.0, kRounding);  // place 0.95 * 4 = 3.8
  EXPECT_NEAR(*speed.kmh.max, 10.0, kRounding);
  EXPECT_NEAR(*speed.kmh.bias, 2.5, kRounding);
  EXPECT_NEAR(*speed.percent.max, 20.0, kRounding);
  EXPECT_NEAR(*speed.percent.bias, 5.0, kRounding);
  EXPECT_NEAR(*speed.share_within_limits, 3.0 / 5.0, kRounding);
  EXPECT_NEAR(*speed.coverage, 3.0 / 5.0, kRounding);  // +-1 m/s is +-3.6 km/h
  const double mean_square_kmh = (1.0 + 4.0 + 6.25 + 16.0 + 100.0) / 5.0;
  EXPECT_NEAR(*speed.z_rms, std::sqrt(mean_square_kmh) / 3.6 / 0.5, kRounding);
}

TEST(SpeedStatistics, LimitsAreThreeKmhUpToAHundredAndThreePercentAbove) {
  EXPECT_TRUE(pair_kmh(20.0, 2.999).within_limits());
  EXPECT_FALSE(pair_kmh(20.0, 3.001).within_limits());
  EXPECT_TRUE(pair_kmh(99.9, -2.999).within_limits());
  EXPECT_FALSE(pair_kmh(99.9, -3.001).within_limits());
  EXPECT_TRUE(pair_kmh(200.0, 5.999).within_limits());
  EXPECT_FALSE(pair_kmh(200.0, -6.001).within_limits());
}

TEST(SpeedStatistics, WhatIsNotStatedIsAbsent) {
  const SpeedStatistics none = speed_statistics({});
  EXPECT_FALSE(none.kmh.bias || none.percent.max || none.coverage || none.share_within_limits);
  const SpeedPair bare{{0.0, 10.0, {}, {}, {}}, 10.5};
  const SpeedStatistics speed = speed_statistics(std::span(&bare, 1));
  EXPECT_FALSE(speed.coverage || speed.z_rms);
  EXPECT_NEAR(*speed.kmh.bias, -1.8, kRounding);
  const SpeedPair standing{{0.0, 0.1, {}, {}, {}}, 0.0};
  EXPECT_FALSE(standing.error_percent());
}

TEST(SpeedStatistics, HonestIntervalsCoverNinetyFivePercent) {
  constexpr int kTrials = 4000;
  constexpr double kFourSigma = 4.0 * 0.003446;  // sqrt(0.95 * 0.05 / 4000)
  Random random(11);
  std::vector<SpeedPair> pairs;
  for (int trial = 0; trial < kTrials; ++trial) {
    const double stated_mps = random.normal(20.0, 0.4);
    pairs.push_back(
        {{0.0, stated_mps, 0.4, stated_mps - 1.959964 * 0.4, stated_mps + 1.959964 * 0.4}, 20.0});
  }
  const SpeedStatistics speed = speed_statistics(pairs);
  EXPECT_NEAR(*speed.coverage, 0.95, kFourSigma);
  EXPECT_NEAR(*speed.z_rms, 1.0, 4.0 / std::sqrt(2.0 * kTrials));
}

}  // namespace
}  // namespace vildar
