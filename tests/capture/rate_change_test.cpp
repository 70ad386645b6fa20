#include "capture/rate_change.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"
#include "support/trials.h"

namespace vildar {
namespace {

struct Rates {
  double taken_hz, clip_hz, phase;
};

// Of each frame of the clip, the number of the picture that was latest when it was due.
std::vector<std::int64_t> pictures(const Rates& rates, int frames) {
  std::vector<std::int64_t> found;
  for (int k = 0; k < frames; ++k)
    found.push_back(
        static_cast<std::int64_t>(std::floor(k * rates.taken_hz / rates.clip_hz + rates.phase)));
  return found;
}

// Frames at which the picture goes on by so many, but for a share that nothing tells of.
std::vector<std::int64_t> steps_of(const std::vector<std::int64_t>& shown, std::int64_t by,
                                   double untold, Random& random) {
  std::vector<std::int64_t> found;
  for (std::size_t k = 1; k < shown.size(); ++k)
    if (shown[k] - shown[k - 1] == by && random.uniform() >= untold)
      found.push_back(static_cast<std::int64_t>(k));
  return found;
}

// Most by which a frame's time leaves that of its picture, in frames of the clip, the mean apart;
// and that mean.
std::pair<double, double> error_of(const RateChange& change, const Rates& rates,
                                   const std::vector<std::int64_t>& shown) {
  double sum = 0.0, least = INFINITY, most = -INFINITY, sum_from_stamp = 0.0;
  for (std::size_t k = 0; k < shown.size(); ++k) {
    const double at = change.taken_at(static_cast<std::int64_t>(k));
    const double off = at - static_cast<double>(shown[k]) * rates.clip_hz / rates.taken_hz;
    sum += off;
    least = std::min(least, off);
    most = std::max(most, off);
    sum_from_stamp += at - static_cast<double>(k);
  }
  const double n = static_cast<double>(shown.size()), mean = sum / n;
  return {std::max(most - mean, mean - least), sum_from_stamp / n};
}

// Told by all events, and by three of five: those leave the line through n of them unsure by
// 2 / sqrt(12 n) of a frame at its ends.
void expect_told(const Rates& rates, int frames, bool repeats, Random& random) {
  const auto shown = pictures(rates, frames);
  for (const double untold : {0.0, 0.4}) {
    const auto events = steps_of(shown, repeats ? 0 : 2, untold, random);
    const auto change = repeats ? RateChange::by_repeats(events) : RateChange::by_gaps(events);
    const auto told = ::testing::Message()
                      << rates.taken_hz << " made " << rates.clip_hz << ", " << untold << " untold";
    ASSERT_TRUE(change) << told;
    EXPECT_EQ(change->repeats(), repeats) << told;
    const double sigma =
        untold > 0.0 ? 2.0 / std::sqrt(12.0 * static_cast<double>(events.size())) : 0.01;
    EXPECT_NEAR(change->rate_factor(), rates.taken_hz / rates.clip_hz, 8.0 * sigma / frames)
        << told;
    const auto [apart, mean] = error_of(*change, rates, shown);
    EXPECT_LT(apart, 4.0 * sigma) << told;
    EXPECT_NEAR(mean, 0.0, 0.3) << told;
  }
}

TEST(RateChange, FramesShownTwiceAreTakenAtTheTimesOfTheRateBefore) {
  Random random(3);
  for (const Rates& rates : {Rates{25.0, 30.0, 0.0},
                             {25.0, 29.0, 0.3},
                             {24.0, 30.0, 0.71},
                             {25.0, 40.0, 0.2},
                             {30.0, 50.0, 0.0},
                             {25.0, 50.0, 0.0}})
    expect_told(rates, 300, true, random);
  expect_told({29.97, 30.0, 0.5}, 24000, true, random);
}

TEST(RateChange, FramesLeftOutToo) {
  Random random(4);
  for (const Rates& rates :
       {Rates{30.0, 25.0, 0.0}, {30.0, 24.0, 0.4}, {30.0, 28.0, 0.3}, {60.0, 50.0, 0.9}})
    expect_told(rates, 300, false, random);
  expect_told({25.0, 24.0, 0.5}, 600, false, random);
}

TEST(RateChange, FramesAnywhereAreNone) {
  Random random(5);
  for (int trial = 0; trial < trials(600); ++trial) {
    const double share = random.uniform(0.02, 0.6);
    std::vector<std::int64_t> anywhere;
    for (std::int64_t k = 1; k < 300; ++k)
      if (random.uniform() < share) anywhere.push_back(k);
    EXPECT_FALSE(RateChange::by_repeats(anywhere)) << trial;
    EXPECT_FALSE(RateChange::by_gaps(anywhere)) << trial;
  }
}

TEST(RateChange, FewOrAllFramesTellNothing) {
  EXPECT_FALSE(RateChange::by_repeats({}));
  EXPECT_FALSE(RateChange::by_repeats(std::vector<std::int64_t>{6, 12, 18, 24, 30, 36, 42}));
  std::vector<std::int64_t> all;
  for (std::int64_t k = 1; k < 100; ++k) all.push_back(k);
  EXPECT_FALSE(RateChange::by_repeats(all));
}

}  // namespace
}  // namespace vildar
