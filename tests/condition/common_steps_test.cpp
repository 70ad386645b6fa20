#include "condition/common_steps.h"

#include <cmath>

#include <gtest/gtest.h>

#include "condition/noise.h"
#include "core/random.h"

namespace vildar {
namespace {

constexpr double kStepSigma_w = 1e-10;
constexpr double kStepDark_w = 2e-8;

/// A vehicle at 20 m/s that passes two photodiodes 2 m apart, at 5.0 and 4.9 s; up to 1.25e-6 W.
std::vector<PowerTrace> passed_by(double rate_hz) {
  Random random(5);
  std::vector<PowerTrace> traces(2);
  for (int k = 0; k < static_cast<int>(10.0 * rate_hz); ++k)
    for (std::size_t i = 0; i < 2; ++i) {
      const double time_s = k / rate_hz,
                   range_m = 20.0 * (5.0 - time_s) - 2.0 * static_cast<double>(i);
      double light_w = kStepDark_w + random.normal(0.0, kStepSigma_w);
      if (range_m > 0.0) light_w += 2e-5 / (range_m * range_m + 16.0);
      traces[i].time_s.push_back(time_s);
      traces[i].power_w.push_back(static_cast<float>(light_w));
    }
  for (PowerTrace& trace : traces) set_noise(trace);
  return traces;
}

/// Adds to both, `shares` of the height to each, in [from_s, to_s).
void switch_on(std::vector<PowerTrace>& traces, double from_s, double to_s, double height_w,
               std::array<double, 2> shares = {1.0, 0.8}) {
  for (std::size_t i = 0; i < traces.size(); ++i)
    for (std::size_t k = 0; k < traces[i].time_s.size(); ++k)
      if (traces[i].time_s[k] >= from_s && traces[i].time_s[k] < to_s)
        traces[i].power_w[k] += static_cast<float>(shares[i] * height_w);
}

/// Largest difference from what was there before, of samples that are left.
double most_off_w(const PowerTrace& trace, const PowerTrace& clean) {
  double most_w = 0.0;
  for (std::size_t i = 0, of = 0; i < trace.power_w.size(); ++i, ++of) {
    while (clean.time_s[of] != trace.time_s[i]) ++of;
    most_w = std::max(most_w, std::abs(static_cast<double>(trace.power_w[i]) - clean.power_w[of]));
  }
  return most_w;
}

const std::vector<Metres> kTwoMetres{Metres(0.0), Metres(2.0)};

// A sign at 1 to 3 s and across the rise, a beacon of 60 ms every 1.1 s, both at once.
TEST(CommonSteps, WhatIsSwitchedOnAndOffGoes) {
  for (const double rate_hz : {500.0, 1000.0, 10000.0}) {
    const std::vector<PowerTrace> clean = passed_by(rate_hz);
    std::vector<PowerTrace> traces = clean;
    switch_on(traces, 1.0, 3.0, 4e-9);
    switch_on(traces, 4.0, 4.7, 5e-8);
    for (int k = 0; k < 9; ++k) switch_on(traces, 0.35 + 1.1 * k, 0.41 + 1.1 * k, 2e-8, {0.5, 1.0});
    remove_common_steps(traces, kTwoMetres);
    for (std::size_t i = 0; i < 2; ++i) {
      // A step is known to the noise of means over 4 ms, 0.04 of what lies below it in the rise.
      EXPECT_LT(most_off_w(traces[i], clean[i]), 4e-9) << rate_hz << " Hz, " << i;
      EXPECT_GT(100 * traces[i].power_w.size(), 98 * clean[i].power_w.size());
      EXPECT_NEAR(traces[i].switched_w, i == 0 ? 5e-8 : 4e-8, 4e-9);
      EXPECT_GT(traces[i].rejected["switching"], 0);
    }
  }
}

// Each nearer to one of the two, as at a level crossing: what leaves the one comes to the other.
TEST(CommonSteps, LampsThatShineInTurnGo) {
  const std::vector<PowerTrace> clean = passed_by(1000.0);
  std::vector<PowerTrace> traces = clean;
  for (int k = 0; k < 9; ++k) {
    switch_on(traces, 0.2 + k, 0.7 + k, 2e-8, {1.0, 0.4});
    switch_on(traces, 0.7 + k, 1.2 + k, 2e-8, {0.3, 1.0});
  }
  const double before_w = most_off_w(traces[0], clean[0]);
  remove_common_steps(traces, kTwoMetres);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_GT(traces[i].switched_w, 1e-8);
    double lowest_w = INFINITY, highest_w = -INFINITY;
    for (std::size_t k = 0, of = 0; k < traces[i].power_w.size(); ++k, ++of) {
      while (clean[i].time_s[of] != traces[i].time_s[k]) ++of;
      const double off_w = static_cast<double>(traces[i].power_w[k]) - clean[i].power_w[of];
      if (traces[i].time_s[k] < 0.7 || traces[i].time_s[k] > 8.2) continue;
      lowest_w = std::min(lowest_w, off_w);
      highest_w = std::max(highest_w, off_w);
    }
    EXPECT_LT(highest_w - lowest_w, 0.25 * before_w) << i;  // a constant light may stay
  }
}

TEST(CommonSteps, WhatWasOnAtFirstAndGoesOutForAWhileStays) {
  const std::vector<PowerTrace> clean = passed_by(1000.0);
  std::vector<PowerTrace> lit = clean, traces = clean;
  switch_on(lit, 0.0, 10.0, 3e-8);
  switch_on(traces, 0.0, 2.0, 3e-8);
  switch_on(traces, 2.5, 10.0, 3e-8);
  remove_common_steps(traces, kTwoMetres);
  for (std::size_t i = 0; i < 2; ++i) EXPECT_LT(most_off_w(traces[i], lit[i]), 1e-9);
}

// A body that hides the lamps hides them from one photodiode after the other; a lamp that is
// switched on stays on; and lamps that pulse do so at once before both.
TEST(CommonSteps, WhatTheVehicleDoesStays) {
  const std::vector<PowerTrace> clean = passed_by(1000.0);
  std::vector<PowerTrace> hidden = clean, dark = clean, pulsed = clean;
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t k = 0; k < clean[i].time_s.size(); ++k) {
      const double time_s = clean[i].time_s[k],
                   range_m = 20.0 * (5.0 - time_s) - 2.0 * static_cast<double>(i);
      const float light_w = clean[i].power_w[k] - static_cast<float>(kStepDark_w);
      if (range_m > 20.0 && range_m < 25.0) hidden[i].power_w[k] -= light_w;
      if (time_s < 4.0) dark[i].power_w[k] -= light_w;
      if (std::fmod(time_s, 1.0 / 7.0) < 0.05) pulsed[i].power_w[k] -= light_w;
    }
  for (const std::vector<PowerTrace>& before : {clean, hidden, dark, pulsed}) {
    std::vector<PowerTrace> after = before;
    remove_common_steps(after, kTwoMetres);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_EQ(after[i].power_w, before[i].power_w);
      EXPECT_EQ(after[i].switched_w, 0.0);
    }
  }
}

// Six sigmas of a sample: four milliseconds together tell them.
TEST(CommonSteps, SmallOnesGoToo) {
  const std::vector<PowerTrace> clean = passed_by(1000.0);
  std::vector<PowerTrace> traces = clean;
  switch_on(traces, 2.0, 3.5, 6.0 * kStepSigma_w, {1.0, 1.0});
  remove_common_steps(traces, kTwoMetres);
  for (std::size_t i = 0; i < 2; ++i) EXPECT_LT(most_off_w(traces[i], clean[i]), kStepSigma_w);
}

// Lamps with a loose contact, out twice: what shone between was the vehicle.
TEST(CommonSteps, OwnLightBetweenTwoFailuresStays) {
  const std::vector<PowerTrace> clean = passed_by(1000.0);
  std::vector<PowerTrace> traces = clean;
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t k = 0; k < clean[i].time_s.size(); ++k)
      if (const double time_s = clean[i].time_s[k];
          (time_s >= 3.9 && time_s < 4.3) || (time_s >= 4.38 && time_s < 4.5))
        traces[i].power_w[k] = static_cast<float>(kStepDark_w);
  remove_common_steps(traces, kTwoMetres);
  for (std::size_t i = 0; i < 2; ++i) {
    std::size_t of = 0;
    for (std::size_t k = 0; k < traces[i].time_s.size(); ++k, ++of) {
      while (clean[i].time_s[of] != traces[i].time_s[k]) ++of;
      const double time_s = clean[i].time_s[of];
      if (time_s > 4.31 && time_s < 4.37) {
        EXPECT_NEAR(traces[i].power_w[k], clean[i].power_w[of], 1e-9) << time_s;
      }
    }
  }
}

TEST(CommonSteps, NeedTwoPhotodiodesApart) {
  const std::vector<PowerTrace> clean = passed_by(1000.0);
  std::vector<PowerTrace> traces = clean;
  switch_on(traces, 1.0, 3.0, 4e-8);
  const std::vector<PowerTrace> before = traces;
  remove_common_steps(traces, {Metres(0.0), Metres(0.5)});
  EXPECT_EQ(traces[0].power_w, before[0].power_w);
  traces.pop_back();
  remove_common_steps(traces, {Metres(0.0)});
  EXPECT_EQ(traces[0].power_w, before[0].power_w);
}

TEST(CommonSteps, AcrossGapsOfHoursAndInLongRecords) {
  std::vector<PowerTrace> traces = passed_by(1000.0);
  for (PowerTrace& trace : traces)
    for (std::size_t k = 5500; k < trace.time_s.size(); ++k) trace.time_s[k] += 40000.0;
  const std::vector<PowerTrace> clean = traces;
  switch_on(traces, 1.0, 3.0, 4e-8);
  switch_on(traces, 40007.0, 40008.0, 4e-8);
  remove_common_steps(traces, kTwoMetres);
  for (std::size_t i = 0; i < 2; ++i) EXPECT_LT(most_off_w(traces[i], clean[i]), 1e-9);
}

}  // namespace
}  // namespace vildar
