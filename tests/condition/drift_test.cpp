#include "condition/drift.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "condition/condition.h"
#include "condition/noise.h"
#include "core/random.h"

namespace vildar {
namespace {

constexpr double kDriftSigma_w = 2e-4;
constexpr double kDriftRate_hz = 200.0;
constexpr double kAmbient_w = 0.5;

using Light = std::function<double(double)>;

/// A vehicle that is abreast of the photodiode, 5 m away, at `at_s`; 0.04 W there.
Light vehicle(double at_s, double speed_mps) {
  return [=](double time_s) {
    const double along_m = speed_mps * (time_s - at_s);
    return along_m < 0.0 ? 1.0 / (along_m * along_m + 25.0) : 0.0;
  };
}

PowerTrace trace_of(double duration_s, const std::vector<Light>& lights, std::uint64_t seed) {
  Random random(seed);
  PowerTrace trace;
  for (int k = 0; k < duration_s * kDriftRate_hz; ++k) {
    const double time_s = k / kDriftRate_hz;
    double power_w = kAmbient_w + random.normal(0.0, kDriftSigma_w);
    for (const Light& light : lights) power_w += light(time_s);
    trace.time_s.push_back(time_s);
    trace.power_w.push_back(static_cast<float>(power_w));
  }
  set_noise(trace);
  set_ambient(trace);
  return trace;
}

/// Largest error of what is left, as means over 0.5 s, against ambient and the given lights alone.
double worst_error_w(const PowerTrace& trace, const std::vector<Light>& lights) {
  constexpr double kBlock_s = 0.5;
  std::vector<double> errors_w;
  for (const PowerBlock& block : block_means(trace, 0.0, trace.time_s.back(), kBlock_s)) {
    double expected_w = 0.0;
    for (const Light& light : lights)
      for (int i = 0; i < 50; ++i)
        expected_w += light(block.time_s + kBlock_s * ((i + 0.5) / 50.0 - 0.5)) / 50.0;
    errors_w.push_back(block.power_w - expected_w);
  }
  const double level_w = median_of(errors_w);  // which level is left is open
  double worst_w = 0.0;
  for (const double error_w : errors_w) worst_w = std::max(worst_w, std::abs(error_w - level_w));
  return worst_w;
}

// Five sigmas of a mean over 0.5 s, of two independent ones: the samples' and the level's.
const double kBlockNoise_w = 5.0 * std::sqrt(2.0) * kDriftSigma_w / std::sqrt(0.5 * kDriftRate_hz);

struct Change {
  const char* name;
  Light light;
};

std::vector<Change> changes() {
  return {
      {"dusk", [](double t) { return 0.2 * std::exp(-t / 100.0); }},
      {"a lamp that switches on", [](double t) { return t > 97.3 ? 0.05 : 0.0; }},
      {"a lamp that switches off near the end", [](double t) { return t < 288.0 ? 0.05 : 0.0; }},
      {"a cloud", [](double t) { return 0.05 * std::pow(std::sin(kPi * t / 240.0), 2); }}};
}

TEST(RemoveDrift, ChangesOfTheAmbientAreNoPasses) {
  std::uint64_t seed = 1;
  for (const Change& change : changes()) {
    PowerTrace trace = trace_of(300.0, {change.light}, seed++);
    remove_drift(trace);
    EXPECT_GT(trace.drift_w, 0.03) << change.name;
    EXPECT_LT(worst_error_w(trace, {}), 0.02 * 0.05 + kBlockNoise_w) << change.name;
    EXPECT_TRUE(find_passes(trace).empty()) << change.name;
  }
}

// Right after each of them the next one, of a hundred times the power, shines from 90 to 130 m
// away.
TEST(RemoveDrift, DenseTrafficIsNoChangeOfTheAmbient) {
  std::vector<Light> vehicles;
  for (const double at_s : {5.0, 14.0, 22.5, 29.5, 36.0})
    vehicles.push_back([at_s](double time_s) { return 100.0 * vehicle(at_s, 15)(time_s); });
  PowerTrace trace = trace_of(41.0, vehicles, 40);
  const std::vector<float> as_recorded = trace.power_w;
  remove_drift(trace);
  EXPECT_EQ(trace.drift_w, 0.0);
  EXPECT_EQ(trace.power_w, as_recorded);
}

TEST(RemoveDrift, PassesKeepTheirLight) {
  std::uint64_t seed = 20;
  const std::vector<Light> vehicles{vehicle(40, 14), vehicle(65, 8), vehicle(110, 20),
                                    vehicle(111.5, 20), vehicle(200, 3)};
  for (const Change& change : changes()) {
    std::vector<Light> lights = vehicles;
    lights.push_back(change.light);
    PowerTrace trace = trace_of(300.0, lights, seed++);
    remove_drift(trace);
    // A cloud bends by up to 5 % of its light within the 30 s that a pass may last.
    EXPECT_LT(worst_error_w(trace, vehicles), 0.05 * 0.05 + kBlockNoise_w) << change.name;
    const std::vector<PowerPass> passes = find_passes(trace);
    ASSERT_EQ(passes.size(), vehicles.size()) << change.name;
    EXPECT_NEAR(passes[2].peak_s, 110.0, 0.03) << change.name;
    EXPECT_NEAR(passes[4].peak_s, 200.0, 0.1) << change.name;
  }
}

TEST(RemoveDrift, NothingIsTakenFromASteadyTrace) {
  PowerTrace trace = trace_of(120.0, {vehicle(40, 14), vehicle(90, 6)}, 40);
  const std::vector<float> before = trace.power_w;
  remove_drift(trace);
  EXPECT_EQ(trace.power_w, before);
  EXPECT_EQ(trace.drift_w, 0.0);
}

TEST(RemoveDrift, ACrawlingVehicleKeepsItsLight) {
  const std::vector<Light> vehicles{vehicle(90, 1.6)};
  PowerTrace trace = trace_of(120.0, vehicles, 41);
  remove_drift(trace);
  // From further than 48 m it is as slow as dusk: 1.1 % of the 0.04 W that it gives abreast.
  EXPECT_LT(worst_error_w(trace, vehicles), 0.011 * 0.04 + kBlockNoise_w);
}

TEST(RemoveDrift, AStreamOfTrafficWithoutADarkMomentIsNoAmbient) {
  std::vector<Light> vehicles{vehicle(20, 14)};
  for (int k = 0; k < 40; ++k) vehicles.push_back(vehicle(60.0 + 2.0 * k, 14));
  PowerTrace trace = trace_of(200.0, vehicles, 50);
  remove_drift(trace);
  // The first of them is ambient until 3 s before it stands out: 1 % of its 0.04 W.
  EXPECT_LT(worst_error_w(trace, vehicles), 0.01 * 0.04 + kBlockNoise_w);
}

TEST(RemoveDrift, ShortOrEmptyTracesStay) {
  PowerTrace empty;
  remove_drift(empty);
  EXPECT_EQ(empty.drift_w, 0.0);
  PowerTrace brief = trace_of(20.0, {[](double t) { return 0.01 * t; }}, 60);
  remove_drift(brief);
  EXPECT_EQ(brief.drift_w, 0.0);
}

// The dip between two vehicles with which a record begins is no floor.
TEST(Drift, IsNoneBetweenVehiclesInViewAtTheBeginning) {
  const Light one = vehicle(7.0, 14.0), next = vehicle(16.5, 14.0);
  const Light bright = [&](double time_s) { return 10.0 * (one(time_s) + next(time_s)); };
  PowerTrace trace = trace_of(72.5, {bright}, 11);
  remove_drift(trace);
  EXPECT_EQ(trace.drift_w, 0.0);
}

}  // namespace
}  // namespace vildar
