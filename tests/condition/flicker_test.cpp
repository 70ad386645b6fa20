#include "condition/flicker.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "condition/condition.h"
#include "condition/noise.h"
#include "core/random.h"

namespace vildar {
namespace {

constexpr double kFlickerSigma_w = 1e-4;
constexpr double kPass_w = 0.04;  // abreast, 5 m away

double vehicle_w(double time_s) {
  const double along_m = 15.0 * (time_s - 12.0);
  return along_m < 0.0 ? 1.0 / (along_m * along_m + 25.0) : 0.0;
}

struct Scene {
  double rate_hz = 1000.0;
  double mains_hz = 50.0;
  double flicker_w = 0.4;   ///< at twice the mains frequency, ten times the vehicle's light
  double multiple_w = 0.0;  ///< at four times
  double hum_w = 0.0;       ///< at the mains frequency
  double jitter_s = 0.0;    ///< of the instants of sampling, which the stamps tell
  std::function<double(double)> strength = [](double) { return 1.0; };
};

PowerTrace trace_of(const Scene& scene, Random& random) {
  PowerTrace trace;
  for (int k = 0; k < 20.0 * scene.rate_hz; ++k) {
    const double time_s = k / scene.rate_hz + random.uniform(-scene.jitter_s, scene.jitter_s);
    const double turn = 2.0 * kPi * scene.mains_hz * time_s;
    const double light_w = 0.5 + vehicle_w(time_s) +
                           scene.strength(time_s) * scene.flicker_w * std::sin(2.0 * turn + 0.3) +
                           scene.multiple_w * std::sin(4.0 * turn + 1.0) +
                           scene.hum_w * std::sin(turn + 2.0);
    trace.time_s.push_back(time_s);
    trace.power_w.push_back(static_cast<float>(light_w + random.normal(0.0, kFlickerSigma_w)));
  }
  set_noise(trace);
  return trace;
}

/// Root mean square of single samples against the scene without flicker, over the times given.
double error_w(const PowerTrace& trace, double from_s, double to_s) {
  double square = 0.0, count = 0.0;
  for (std::size_t i = 0; i < trace.time_s.size(); ++i) {
    if (trace.time_s[i] < from_s || trace.time_s[i] > to_s) continue;
    square += std::pow(trace.power_w[i] - 0.5 - vehicle_w(trace.time_s[i]), 2);
    count += 1.0;
  }
  return std::sqrt(square / count);
}

TEST(RemoveFlicker, LightWithoutNoiseHasNone) {
  for (const double rate_hz : {1000.0, 20000.0})
    for (const double step_w : {0.0, 1e-5}) {
      PowerTrace trace;
      for (int k = 0; k < 15.0 * rate_hz; ++k) {
        const double light_w = 0.5 + vehicle_w(k / rate_hz);
        trace.time_s.push_back(k / rate_hz);
        trace.power_w.push_back(
            static_cast<float>(step_w > 0.0 ? std::round(light_w / step_w) * step_w : light_w));
      }
      set_noise(trace);
      const std::vector<float> before_w = trace.power_w;
      remove_flicker(trace, 50.0);
      EXPECT_EQ(trace.flicker_w, 0.0) << rate_hz << " Hz, " << step_w << " W";
      EXPECT_EQ(trace.power_w, before_w);
    }
}

TEST(RemoveFlicker, IsTakenOutTenTimesOverTheSignal) {
  // The noise itself, and a thousandth of the flicker: amplitude and phase of 11 blocks of 0.1 s.
  constexpr double kLeft = 1e-3;
  Random random(1);
  for (const double mains_hz : {49.8, 50.0, 50.13, 50.2, 59.8, 60.0, 60.2}) {
    for (const double rate_hz : {330.0, 1000.0, 1024.0, 10000.0}) {
      PowerTrace trace = trace_of({.rate_hz = rate_hz, .mains_hz = mains_hz}, random);
      remove_flicker(trace, mains_hz < 55.0 ? 50.0 : 60.0);
      ASSERT_NEAR(trace.mains_hz, mains_hz, 0.01) << rate_hz;
      EXPECT_NEAR(trace.flicker_w, 0.4, 0.004) << rate_hz;
      EXPECT_LT(error_w(trace, 1.0, 10.0), 1.1 * kFlickerSigma_w + kLeft * 0.4)
          << mains_hz << " sampled at " << rate_hz;
      EXPECT_LT(error_w(trace, 10.0, 13.0), 1.1 * kFlickerSigma_w + kLeft * 0.4 + 0.01 * kPass_w)
          << "beside a pass; " << mains_hz << " sampled at " << rate_hz;
    }
  }
}

TEST(RemoveFlicker, PassesAreFoundUnderIt) {
  Random random(2);
  for (const double mains_hz : {49.85, 60.1}) {
    PowerTrace trace = trace_of({.mains_hz = mains_hz, .multiple_w = 0.1, .hum_w = 0.05}, random);
    remove_flicker(trace, 50.0);  // a wrong or missing mains_hz is found out
    set_noise(trace);
    EXPECT_NEAR(trace.mains_hz, mains_hz, 0.01);
    EXPECT_NEAR(trace.noise_sigma_w, kFlickerSigma_w, 0.15 * kFlickerSigma_w);
    const std::vector<PowerPass> passes = find_passes(trace);
    ASSERT_EQ(passes.size(), 1U) << mains_hz;
    EXPECT_NEAR(passes[0].peak_s, 12.0, 0.03);
    EXPECT_NEAR(passes[0].to_s, 12.0, 0.05);
  }
}

TEST(RemoveFlicker, IsFollowedWhereItChanges) {
  Random random(3);
  Scene scene{.mains_hz = 50.1};
  scene.strength = [](double time_s) { return 0.5 + 0.5 * std::sin(0.3 * time_s); };
  PowerTrace trace = trace_of(scene, random);
  remove_flicker(trace, 50.0);
  // Mean over 1.1 s of a sine of 0.3 rad/s: 1 - 0.3^2 1.1^2 / 24 of it.
  EXPECT_LT(error_w(trace, 2.0, 18.0), 1.1 * kFlickerSigma_w + 0.005 * 0.4);
}

TEST(RemoveFlicker, StampsThatTellUnevenSamplingAreUsed) {
  Random random(4);
  PowerTrace trace = trace_of({.mains_hz = 50.07, .jitter_s = 4e-4}, random);
  remove_flicker(trace, 50.0);
  EXPECT_LT(error_w(trace, 1.0, 10.0), 1.1 * kFlickerSigma_w + 2e-3 * 0.4);
}

TEST(RemoveFlicker, StampsSince1970AreNoOtherTrace) {
  // A double holds them to 0.2 us: the uneven ones fall on either side of any limit between blocks.
  constexpr double kSince1970_s = 1'763'769'600.25, kLimit_s = 0.1;
  Random random(4);
  PowerTrace trace = trace_of({.mains_hz = 50.07, .jitter_s = 4e-4}, random);
  for (std::size_t i = 100; i < trace.time_s.size(); i += 100)
    trace.time_s[i] = trace.time_s[0] + kLimit_s * static_cast<double>(i / 100) - 1.5e-7;
  PowerTrace late = trace;
  for (double& time_s : late.time_s) time_s += kSince1970_s;
  remove_flicker(trace, 50.0);
  remove_flicker(late, 50.0);
  EXPECT_NEAR(late.mains_hz, trace.mains_hz, 1e-3);
  EXPECT_NEAR(late.flicker_w, trace.flicker_w, 0.01 * trace.flicker_w);
}

TEST(RemoveFlicker, AClockThatIsSetOnTheWayIsAGap) {
  Random random(8);
  PowerTrace trace = trace_of({.mains_hz = 50.07}, random);
  const std::vector<double> times_s = trace.time_s;
  for (std::size_t i = 13'000; i < times_s.size(); ++i) trace.time_s[i] += 1'763'769'600.0;
  remove_flicker(trace, 50.0);
  EXPECT_NEAR(trace.mains_hz, 50.07, 0.01);
  trace.time_s = times_s;
  EXPECT_LT(error_w(trace, 1.0, 10.0), 1.1 * kFlickerSigma_w + 2e-3 * 0.4);
}

TEST(RemoveFlicker, ATraceWithoutItStays) {
  Random random(5);
  for (int trial = 0; trial < 20; ++trial) {
    PowerTrace trace = trace_of({.flicker_w = 0.0}, random);
    const std::vector<float> before = trace.power_w;
    remove_flicker(trace, 50.0);
    EXPECT_EQ(trace.flicker_w, 0.0);
    EXPECT_EQ(trace.power_w, before);
  }
  PowerTrace empty;
  remove_flicker(empty, 50.0);
  EXPECT_EQ(empty.mains_hz, 0.0);
}

TEST(RemoveFlicker, WhatIsSampledLikeSlowLightStays) {
  Random random(6);
  for (const double rate_hz : {100.0, 105.0, 200.0}) {
    PowerTrace trace = trace_of({.rate_hz = rate_hz, .mains_hz = 50.1}, random);
    const std::vector<float> before = trace.power_w;
    remove_flicker(trace, 50.0);
    EXPECT_EQ(trace.power_w, before) << rate_hz;
  }
}

}  // namespace
}  // namespace vildar
