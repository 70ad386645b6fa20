#include "condition/pulsing_lamps.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "condition/noise.h"
#include "core/random.h"

namespace vildar {
namespace {

constexpr double kSigma_w = 1e-10, kLevel_w = 2e-8;

struct Lamps {
  double frequency_hz = 0.0, duty = 1.0, phase = 0.0;
  double passes_s = 5.0;

  /// Time they were on until `time_s`, in periods.
  double on_until(double time_s) const {
    const double periods = time_s * frequency_hz + phase;
    return std::floor(periods) * duty + std::min(periods - std::floor(periods), duty);
  }
  /// While they are on, less than 1 where they are so for a part of the sample alone.
  double share(double time_s, double sample_s) const {
    if (duty == 1.0) return 1.0;
    if (sample_s > 0.0)
      return (on_until(time_s + 0.5 * sample_s) - on_until(time_s - 0.5 * sample_s)) /
             (frequency_hz * sample_s);
    const double periods = time_s * frequency_hz + phase;
    return periods - std::floor(periods) < duty ? 1.0 : 0.0;
  }
};

/// 1.2e-8 W on average from 40 m, gone at once when it is past.
double mean_light_w(const Lamps& lamps, double time_s) {
  const double range_m = 20.0 * (lamps.passes_s - time_s);
  return range_m > 0.0 ? 2e-5 / (range_m * range_m + 16.0) : 0.0;
}

/// `averages`: samples are means over their period, not of one instant.
PowerTrace trace_of(std::initializer_list<Lamps> vehicles, double rate_hz, bool averages) {
  Random random(3);
  PowerTrace trace;
  for (int k = 0; k < static_cast<int>(12.0 * rate_hz); ++k) {
    const double time_s = k / rate_hz;
    double light_w = kLevel_w + random.normal(0.0, kSigma_w);
    for (const Lamps& lamps : vehicles)
      light_w += mean_light_w(lamps, time_s) / lamps.duty *
                 lamps.share(time_s, averages ? 1.0 / rate_hz : 0.0);
    trace.time_s.push_back(time_s);
    trace.power_w.push_back(static_cast<float>(light_w));
  }
  set_noise(trace);
  return trace;
}

/// Least and greatest ratio of the trace's light to what it is on average, of means over 0.1 s
/// where light is bright.
struct Ratios {
  double least = INFINITY, most = 0.0;
};

Ratios ratios_of(const PowerTrace& trace, std::initializer_list<Lamps> vehicles, double to_s) {
  Ratios ratios;
  const auto samples = static_cast<std::size_t>(std::lround(0.1 / trace.sample_period_s));
  for (std::size_t first = 0; first + samples <= trace.time_s.size(); first += samples) {
    double seen_w = 0.0, true_w = 0.0;
    for (std::size_t i = first; i < first + samples; ++i) {
      seen_w += trace.power_w[i] - kLevel_w;
      for (const Lamps& lamps : vehicles) true_w += mean_light_w(lamps, trace.time_s[i]);
    }
    constexpr double kBright_w = 4e-9;
    if (true_w < kBright_w * static_cast<double>(samples) || trace.time_s[first] > to_s) continue;
    ratios.least = std::min(ratios.least, seen_w / true_w);
    ratios.most = std::max(ratios.most, seen_w / true_w);
  }
  return ratios;
}

constexpr double kUntil_s = 4.75;

std::string named(const Lamps& lamps, double rate_hz, bool averages) {
  return std::to_string(lamps.frequency_hz) + " Hz, " + std::to_string(lamps.duty) + ", " +
         std::to_string(rate_hz) + (averages ? " means/s" : " instants/s");
}

void expect_evened_out(const Lamps& lamps, double rate_hz, bool averages) {
  SCOPED_TRACE(named(lamps, rate_hz, averages));
  PowerTrace trace = trace_of({lamps}, rate_hz, averages);
  even_out_pulses(trace);
  ASSERT_EQ(trace.pulsing.size(), 1U);
  const PulsingLight& found = trace.pulsing.front();
  EXPECT_NEAR(found.frequency_hz, lamps.frequency_hz, 0.05);
  const double doubt = found.duty_std / found.duty;
  constexpr double kOfInstants = 0.01,
                   kOfMeans = 0.03;  // by means over whole periods it is not used
  EXPECT_NEAR(found.duty, lamps.duty, (averages ? kOfMeans : kOfInstants) + 2.5 * found.duty_std);
  // The shape of the rise is what speed comes of.
  const Ratios ratios = ratios_of(trace, {lamps}, kUntil_s);
  EXPECT_LT(ratios.most / ratios.least, 1.03);
  EXPECT_LT(ratios.most, std::exp(0.03 + 2.5 * doubt));
  EXPECT_GT(ratios.least, std::exp(-0.03 - 2.5 * doubt));
}

TEST(EvenOutPulses, LampsOfAnyFrequencyAndDutyGiveTheirMeanLight) {
  Random random(5);
  for (int trial = 0; trial < 40; ++trial)
    for (const bool averages : {false, true}) {
      const double duty = 0.25 + 0.5 * random.uniform(), phase = random.uniform();
      expect_evened_out({90.0 + 130.0 * random.uniform(), duty, phase}, 1000.0, averages);
      expect_evened_out({90.0 + 900.0 * random.uniform(), duty, phase}, 10000.0, averages);
    }
}

TEST(EvenOutPulses, LampsInStepWithTheSamples) {
  for (const double phase : {0.07, 0.32, 0.57, 0.82})  // no edge on a sample
    for (const double off_hz : {0.0, 0.02, 0.2})
      for (const double frequency_hz : {100.0, 200.0, 250.0})
        for (const double duty : {0.3, 0.5})
          expect_evened_out({frequency_hz + off_hz, duty, phase}, 1000.0, false);
}

TEST(EvenOutPulses, EachVehicleHasItsOwnFrequency) {
  const Lamps first{123.0, 0.3, 0.2, 5.0}, second{213.7, 0.45, 0.6, 8.0};
  PowerTrace trace = trace_of({first, second}, 5000.0, false);
  even_out_pulses(trace);
  bool found_first = false, found_second = false;
  for (const PulsingLight& light : trace.pulsing) {
    const bool of_first = std::abs(light.frequency_hz - first.frequency_hz) < 0.2;
    const bool of_second = std::abs(light.frequency_hz - second.frequency_hz) < 0.2;
    EXPECT_TRUE(of_first || of_second) << light.frequency_hz;
    found_first |= of_first;
    found_second |= of_second;
  }
  EXPECT_TRUE(found_first && found_second);
  const Ratios before = ratios_of(trace, {first, second}, kUntil_s);
  EXPECT_LT(before.most / before.least, 1.05);
}

TEST(EvenOutPulses, SteadyLampsAndMainsFlickerStay) {
  const Lamps steady{};
  for (const double flicker_w : {0.0, 5e-9, 5e-7})
    for (const double rate_hz : {500.0, 1000.0, 10000.0}) {
      PowerTrace trace = trace_of({steady}, rate_hz, false);
      for (std::size_t i = 0; i < trace.time_s.size(); ++i)
        trace.power_w[i] += static_cast<float>(
            flicker_w * std::abs(std::sin(2.0 * std::numbers::pi * 50.03 * trace.time_s[i])));
      set_noise(trace);
      const PowerTrace before = trace;
      even_out_pulses(trace);
      EXPECT_EQ(trace.power_w, before.power_w) << flicker_w << ' ' << rate_hz;
      EXPECT_TRUE(trace.pulsing.empty());
    }
}

TEST(EvenOutPulses, WhatIsOnForLessThanASampleStays) {
  PowerTrace trace = trace_of({Lamps{433.0, 0.3, 0.1}}, 1000.0, false);
  const PowerTrace before = trace;
  even_out_pulses(trace);
  EXPECT_EQ(trace.power_w, before.power_w);
}

TEST(EvenOutPulses, OfAnEmptyTraceOrOneOfFewSamplesNothingIsSaid) {
  PowerTrace trace;
  even_out_pulses(trace);
  for (int k = 0; k < 5; ++k) {
    trace.time_s.push_back(k * 1e-3);
    trace.power_w.push_back(1e-9F);
  }
  set_noise(trace);
  even_out_pulses(trace);
  EXPECT_EQ(trace.power_w.size(), 5U);
  EXPECT_TRUE(trace.pulsing.empty());
}

}  // namespace
}  // namespace vildar
