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

// Sites whose offset and rims are drawn from what the file and the estimator take beforehand, and
// vehicles that brake or speed up by 1 m/s^2 once the camera has lost them.
struct ClockCase {
  const char* name;
  int passes;
  std::size_t photodiodes;
  simulated::RimWorld world;
  double most_s;  // root mean square error
};

void study_clock(ClockCase one, std::uint64_t seed) {
  Random random(seed);
  Errors errors;
  int missed = 0, told = 0;
  simulated::RimWorld& world = one.world;
  world.unseen_mps2 = 1.0;
  for (int i = 0; i < kSites; ++i) {
    world.time_offset_s = random.normal(0.0, world.offset_std_s);
    world.rim_off_rad.clear();
    for (std::size_t k = 0; k < one.photodiodes; ++k)
      world.rim_off_rad.push_back(random.normal(0.0, radians_from_degrees(1.0)));
    const auto scene =
        simulated::timed_passes(one.passes, world, seed + 1 + static_cast<std::uint64_t>(i));
    const auto learning = std::get<ClockLearning>(learn_clock(scene.passes, scene.site));
    told += learning.clock.passes;
    if (learning.clock.learned)
      errors.add(learning.clock.after.mean - world.time_offset_s, learning.clock.after.std);
    else
      ++missed;
  }
  std::printf("%s: %d passes, %.1f tell, %d sites without answer\n", one.name, one.passes,
              static_cast<double>(told) / kSites, missed);
  errors.print("time offset, ms", 1e3);
  // Errors scatter by a tenth of themselves, and coverage as above.
  EXPECT_LT(missed, kSites / 2);
  EXPECT_GT(errors.coverage(), 0.865);
  EXPECT_LT(std::sqrt(errors.squares / errors.count), 1.3 * one.most_s);
}

using LearnClockStudy = Study;

TEST_F(LearnClockStudy, TenPasses) { study_clock({"one photodiode", 10, 1, {}, 0.004}, 20260501); }
TEST_F(LearnClockStudy, FortyPasses) {
  study_clock({"one photodiode", 40, 1, {}, 0.002}, 20260502);
}
TEST_F(LearnClockStudy, TwoPhotodiodes) {
  study_clock({"two photodiodes", 10, 2, {}, 0.0025}, 20260503);
}
TEST_F(LearnClockStudy, ClocksApartByASecond) {
  study_clock({"clocks apart by a second", 40, 1, {.offset_std_s = 1.0}, 0.002}, 20260504);
}
TEST_F(LearnClockStudy, LightFromTheMiddle) {
  study_clock({"all light at once", 10, 1, {.one_lamp = true}, 0.003}, 20260507);
}
TEST_F(LearnClockStudy, NarrowView) {
  study_clock({"view of 25 degrees", 10, 1, {.half_view_rad = radians_from_degrees(25.0)}, 0.006},
              20260508);
}
TEST_F(LearnClockStudy, SoftRims) {
  study_clock({"rims 13 mrad wide", 10, 1, {.rim_width_rad = 0.003}, 0.003}, 20260509);
  study_clock({"rims 26 mrad wide", 10, 1, {.rim_width_rad = 0.006}, 0.003}, 20260510);
}
TEST_F(LearnClockStudy, UnevenStamps) {
  study_clock({"stamps off by half a period", 10, 1, {.jitter = 1.0}, 0.004}, 20260511);
}
TEST_F(LearnClockStudy, TenKilohertz) {
  study_clock({"10 kHz", 10, 1, {.rate_hz = 10000.0}, 0.003}, 20260505);
}
TEST_F(LearnClockStudy, FiveHundredHertz) {
  study_clock({"500 Hz", 10, 1, {.rate_hz = 500.0}, 0.004}, 20260506);
}

}  // namespace
}  // namespace vildar
