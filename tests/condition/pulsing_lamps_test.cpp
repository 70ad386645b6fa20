#include "condition/pulsing_lamps.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "condition/flicker.h"
#include "condition/noise.h"
#include "core/random.h"

namespace vildar {
namespace {

constexpr double kPulseSigma_w = 1e-10, kLevel_w = 2e-8;

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
    double light_w = kLevel_w + random.normal(0.0, kPulseSigma_w);
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

/// False where the trace stays.
bool expect_evened_out(const Lamps& lamps, double rate_hz, bool averages) {
  SCOPED_TRACE(named(lamps, rate_hz, averages));
  PowerTrace trace = trace_of({lamps}, rate_hz, averages);
  even_out_pulses(trace);
  if (trace.pulsing.empty()) return false;
  EXPECT_EQ(trace.pulsing.size(), 1U);
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
  return true;
}

TEST(EvenOutPulses, LampsOfAnyFrequencyAndDutyGiveTheirMeanLight) {
  Random random(5);
  int tried = 0, done = 0;
  for (int trial = 0; trial < 40; ++trial)
    for (const bool averages : {false, true}) {
      const double duty = 0.25 + 0.5 * random.uniform(), phase = random.uniform();
      done += expect_evened_out({90.0 + 130.0 * random.uniform(), duty, phase}, 1000.0, averages);
      done += expect_evened_out({90.0 + 900.0 * random.uniform(), duty, phase}, 10000.0, averages);
      tried += 2;
    }
  // Means over a sample look like slow edges where they are nearly in step with the lamps.
  EXPECT_GE(done, tried - tried / 40);
}

TEST(EvenOutPulses, LampsInStepWithTheSamples) {
  for (const double phase : {0.07, 0.32, 0.57, 0.82})  // no edge on a sample
    for (const double off_hz : {0.0, 0.02, 0.2})
      for (const double frequency_hz : {100.0, 200.0, 250.0})
        for (const double duty : {0.3, 0.5})
          EXPECT_TRUE(expect_evened_out({frequency_hz + off_hz, duty, phase}, 1000.0, false))
              << frequency_hz + off_hz << ' ' << duty << ' ' << phase;
}

// One behind another: all of it, with what either gives, or nothing.
TEST(EvenOutPulses, EachVehicleHasItsOwnFrequency) {
  int done = 0;
  for (const double behind_s : {1.5, 3.0, 4.5, 6.0}) {
    const Lamps first{123.0, 0.3, 0.2, 5.0}, second{213.7, 0.45, 0.6, 5.0 + behind_s};
    PowerTrace trace = trace_of({first, second}, 10000.0, false);
    const PowerTrace before = trace;
    even_out_pulses(trace);
    if (trace.pulsing.empty()) {
      EXPECT_EQ(trace.power_w, before.power_w) << behind_s;
      continue;
    }
    ++done;
    const Ratios near = ratios_of(trace, {first, second}, kUntil_s);
    EXPECT_LT(near.most / near.least, 1.15) << behind_s;
  }
  EXPECT_GT(done, 0);
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

// By up to 1 % of the level that they light, 4 % of the vehicle's light from 60 m.
TEST(EvenOutPulses, LampsBesideStreetLampsThatFlicker) {
  for (const double frequency_hz : {130.0, 200.0, 217.0, 410.0})
    for (const double duty : {0.3, 0.45, 0.7})
      for (const double flicker_w : {1e-10, 2e-10}) {
        const Lamps lamps{frequency_hz, duty, 0.2};
        PowerTrace trace = trace_of({lamps}, 10000.0, false);
        for (std::size_t i = 0; i < trace.time_s.size(); ++i)
          trace.power_w[i] += static_cast<float>(
              flicker_w * std::cos(2.0 * std::numbers::pi * 100.06 * trace.time_s[i]));
        set_noise(trace);
        even_out_pulses(trace);
        ASSERT_EQ(trace.pulsing.size(), 1U) << frequency_hz << ' ' << duty << ' ' << flicker_w;
        EXPECT_NEAR(trace.pulsing.front().frequency_hz, frequency_hz, 0.05);
        EXPECT_NEAR(trace.pulsing.front().duty, duty, 0.01);
        remove_flicker(trace, 50.0);
        const Ratios ratios = ratios_of(trace, {lamps}, kUntil_s);
        EXPECT_LT(ratios.most, 1.03) << frequency_hz << ' ' << duty << ' ' << flicker_w;
        EXPECT_GT(ratios.least, 0.97) << frequency_hz << ' ' << duty << ' ' << flicker_w;
      }
}

TEST(EvenOutPulses, WhatIsOnForLessThanASampleStays) {
  for (const Lamps& lamps : {Lamps{433.0, 0.3, 0.1}, Lamps{203.0, 0.15, 0.1}}) {
    PowerTrace trace = trace_of({lamps}, 1000.0, false);
    const PowerTrace before = trace;
    even_out_pulses(trace);
    EXPECT_EQ(trace.power_w, before.power_w) << lamps.frequency_hz;
    EXPECT_TRUE(trace.pulsing.empty());
  }
}

// Low passes whose edges take longer than the lamps are on, and samples that clip.
TEST(EvenOutPulses, WhereNoLevelIsSeenTheTraceStaysOrIsRight) {
  const Lamps lamps{203.0, 0.3, 0.1};
  const PowerTrace sharp = trace_of({lamps}, 10000.0, false);
  for (const double pole_hz : {60.0, 150.0, 300.0}) {
    PowerTrace trace = sharp;
    const double share = 1.0 - std::exp(-2.0 * std::numbers::pi * pole_hz / 10000.0);
    double level_w = kLevel_w;
    for (float& power_w : trace.power_w)
      power_w = static_cast<float>(level_w += share * (power_w - level_w));
    // Every tenth of an instant: at 1 kHz.
    for (std::size_t i = 0; 10 * i < trace.power_w.size(); ++i) {
      trace.power_w[i] = trace.power_w[10 * i];
      trace.time_s[i] = trace.time_s[10 * i];
    }
    trace.power_w.resize(trace.power_w.size() / 10);
    trace.time_s.resize(trace.power_w.size());
    set_noise(trace);
    const PowerTrace before = trace;
    even_out_pulses(trace);
    if (trace.pulsing.empty()) {
      EXPECT_EQ(trace.power_w, before.power_w) << pole_hz;
    } else {
      const Ratios ratios = ratios_of(trace, {lamps}, kUntil_s);
      EXPECT_LT(ratios.most / ratios.least, 1.05) << pole_hz;
    }
  }
  PowerTrace clipped = sharp;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < clipped.power_w.size(); ++i) {
    constexpr double kFull_w = 4e-7;
    if (clipped.power_w[i] > kFull_w) continue;
    clipped.power_w[kept] = clipped.power_w[i];
    clipped.time_s[kept++] = clipped.time_s[i];
  }
  clipped.power_w.resize(kept);
  clipped.time_s.resize(kept);
  const PowerTrace before = clipped;
  even_out_pulses(clipped);
  EXPECT_TRUE(clipped.pulsing.empty());
  EXPECT_EQ(clipped.power_w, before.power_w);
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
