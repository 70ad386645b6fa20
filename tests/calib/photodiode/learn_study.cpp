#include <cmath>
#include <cstdio>

#include "calib/photodiode/learn.h"
#include "estimate/simulated_beam.h"
#include "estimate/study.h"
#include "simulated_photodiodes.h"
#include "simulated_rims.h"

namespace vildar {
namespace {

constexpr int kSites = 60;

struct Errors {
  int count = 0, inside = 0;
  double squares = 0.0, whitened = 0.0, stds = 0.0;
  void add(double error, double std) {
    ++count;
    inside += std::abs(error) < 1.96 * std ? 1 : 0;
    squares += error * error;
    whitened += error * error / (std * std);
    stds += std;
  }
  double coverage() const { return static_cast<double>(inside) / count; }
  void print(const char* name, double scale) const {
    std::printf("%s: rms %.2f, stated %.2f, coverage %.3f, z rms %.2f\n", name,
                scale * std::sqrt(squares / count), scale * stds / count, coverage(),
                std::sqrt(whitened / count));
  }
};

struct Found {
  Errors means, stated;
  int missed = 0;
};

Found study(int passes, std::uint64_t seed) {
  Random random(seed);
  Found found;
  for (int i = 0; i < kSites; ++i) {
    const double offset_s = random.normal(0.0, 0.03), ratio = std::exp(random.normal(0.0, 0.1));
    const auto scene =
        simulated::lit_passes(passes, offset_s, ratio, seed + 1 + static_cast<std::uint64_t>(i));
    const auto outcome = learn_gains(scene.passes, scene.site);
    const auto* learning = std::get_if<GainLearning>(&outcome);
    if (learning == nullptr) {
      ++found.missed;
      continue;
    }
    const LearnedGain& gain = learning->gains.front();
    const double error = std::log(gain.after.mean / ratio);
    found.means.add(error, gain.mean_std / gain.after.mean);
    found.stated.add(error, gain.after.std / gain.after.mean);
  }
  std::printf("%d passes, %d sites without answer\n", passes, found.missed);
  found.means.print("gain ratio, sigma of the mean, %", 100.0);
  found.stated.print("gain ratio, sigma as written, %", 100.0);
  return found;
}

// A coverage of 60 scatters by 0.028; three of these below.
void expect_true_sigmas(const Found& found) {
  EXPECT_GT(found.means.coverage(), 0.865);
  EXPECT_GT(found.stated.coverage(), 0.865);
  EXPECT_EQ(found.missed, 0);
}

using LearnGainsStudy = Study;

TEST_F(LearnGainsStudy, TenPasses) { expect_true_sigmas(study(10, 20260401)); }
TEST_F(LearnGainsStudy, FortyPasses) { expect_true_sigmas(study(40, 20260402)); }

// Sites whose offset and rims are drawn from what the file and the estimator take beforehand.
Errors clock_study(const char* name, int passes, std::size_t photodiodes, simulated::RimWorld world,
                   std::uint64_t seed) {
  Random random(seed);
  Errors errors;
  int missed = 0, told = 0;
  for (int i = 0; i < kSites; ++i) {
    world.time_offset_s = random.normal(0.0, world.offset_std_s);
    world.rim_off_rad.clear();
    for (std::size_t k = 0; k < photodiodes; ++k)
      world.rim_off_rad.push_back(random.normal(0.0, radians_from_degrees(1.0)));
    const auto scene =
        simulated::timed_passes(passes, world, seed + 1 + static_cast<std::uint64_t>(i));
    const auto learning = std::get<ClockLearning>(learn_clock(scene.passes, scene.site));
    told += learning.clock.passes;
    if (learning.clock.passes < kFewestClockPasses)
      ++missed;
    else
      errors.add(learning.clock.after.mean - world.time_offset_s, learning.clock.after.std);
  }
  std::printf("%s: %d passes, %.1f tell, %d sites without answer\n", name, passes,
              static_cast<double>(told) / kSites, missed);
  errors.print("time offset, ms", 1e3);
  return errors;
}

// Errors scatter by a tenth of themselves, and coverage as above.
void expect_a_clock(const Errors& errors, double most_s) {
  EXPECT_GT(errors.coverage(), 0.865);
  EXPECT_LT(std::sqrt(errors.squares / errors.count), 1.3 * most_s);
}

using LearnClockStudy = Study;

TEST_F(LearnClockStudy, TenPasses) {
  expect_a_clock(clock_study("one photodiode", 10, 1, {}, 20260501), 0.001);
}
TEST_F(LearnClockStudy, FortyPasses) {
  expect_a_clock(clock_study("one photodiode", 40, 1, {}, 20260502), 0.0003);
}
TEST_F(LearnClockStudy, TwoPhotodiodes) {
  expect_a_clock(clock_study("two photodiodes", 10, 2, {}, 20260503), 0.001);
}
TEST_F(LearnClockStudy, ClocksApartByASecond) {
  expect_a_clock(clock_study("two photodiodes", 10, 2, {.offset_std_s = 1.0}, 20260504), 0.001);
}
TEST_F(LearnClockStudy, LightFromTheMiddle) {
  expect_a_clock(clock_study("all light at once", 10, 1, {.one_lamp = true}, 20260507), 0.001);
}
TEST_F(LearnClockStudy, TenKilohertz) {
  expect_a_clock(clock_study("10 kHz", 10, 1, {.rate_hz = 10000.0}, 20260505), 0.001);
}
TEST_F(LearnClockStudy, FiveHundredHertz) {
  expect_a_clock(clock_study("500 Hz", 10, 1, {.rate_hz = 500.0}, 20260506), 0.0015);
}

}  // namespace
}  // namespace vildar
