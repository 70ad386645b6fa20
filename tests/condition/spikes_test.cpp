#include "condition/spikes.h"

#include <gtest/gtest.h>

#include <cmath>

#include "condition/noise.h"
#include "core/random.h"

namespace vildar {
namespace {

constexpr double kSpikeSigma_w = 1e-10;

/// Vehicles that come and vanish at once at 5 and 15 s of 20 s, over a level with noise.
PowerTrace trace_at(double rate_hz, double noise_w = kSpikeSigma_w) {
  Random random(3);
  PowerTrace trace;
  const auto samples = static_cast<int>(20.0 * rate_hz);
  for (int k = 0; k < samples; ++k) {
    const double time_s = k / rate_hz;
    double light_w = 2e-8 + random.normal(0.0, 1.0) * noise_w;
    for (const double past_s : {5.0, 15.0})
      if (const double range_m = 30.0 * (past_s - time_s); range_m > 0.0)
        light_w += 2e-5 / (range_m * range_m + 16.0);
    trace.time_s.push_back(time_s);
    trace.power_w.push_back(static_cast<float>(light_w));
  }
  set_noise(trace);
  return trace;
}

TEST(DropSpikes, LightOfVehiclesStaysAtAnyRate) {
  for (const double rate_hz : {100.0, 250.0, 1000.0, 10000.0})
    for (const double noise_w : {0.0, kSpikeSigma_w, 30.0 * kSpikeSigma_w}) {
      PowerTrace trace = trace_at(rate_hz, noise_w);
      const std::size_t samples = trace.power_w.size();
      EXPECT_EQ(drop_spikes(trace), 0) << rate_hz << " Hz, noise " << noise_w;
      EXPECT_EQ(trace.power_w.size(), samples);
      EXPECT_EQ(trace.time_s.size(), samples);
    }
}

TEST(DropSpikes, OneSampleInAHundredOfAnySignGoes) {
  for (const double rate_hz : {100.0, 1000.0, 10000.0}) {
    const PowerTrace clean = trace_at(rate_hz);
    PowerTrace trace = clean;
    Random random(4);
    std::int64_t spikes = 0;
    std::size_t last = 0;
    for (std::size_t i = 20; i + 20 < trace.power_w.size(); ++i) {
      if (i - last < 20 || random.uniform() > 0.01) continue;
      last = i;
      ++spikes;
      const double sign = random.uniform() < 0.5 ? -1.0 : 1.0;
      trace.power_w[i] += static_cast<float>(sign * random.uniform(3e-6, 9e-6));
    }
    set_noise(trace);
    const auto dropped = static_cast<double>(drop_spikes(trace));
    EXPECT_LE(dropped, static_cast<double>(spikes)) << rate_hz;
    EXPECT_GT(dropped, 0.97 * static_cast<double>(spikes)) << rate_hz;
    // What is left is the trace itself, but for the few that stay.
    std::int64_t strange = 0;
    for (std::size_t i = 0, at = 0; i < trace.power_w.size(); ++i) {
      while (clean.time_s[at] != trace.time_s[i]) ++at;
      strange += trace.power_w[i] != clean.power_w[at];
    }
    EXPECT_EQ(strange, spikes - static_cast<std::int64_t>(dropped)) << rate_hz;
  }
}

TEST(DropSpikes, TwoSamplesInARowGo) {
  PowerTrace trace = trace_at(1000.0);
  for (const std::size_t i : {2000U, 4000U, 9000U})
    for (const std::size_t off : {0U, 1U}) trace.power_w[i + off] += 5e-7F;
  EXPECT_EQ(drop_spikes(trace), 6);
}

TEST(DropSpikes, LampsThatPulseStayAsTheyAre) {
  for (const double duty : {0.1, 0.2, 0.5, 0.9}) {
    PowerTrace trace = trace_at(1000.0);
    const std::size_t samples = trace.power_w.size();
    for (std::size_t i = 0; i < samples; ++i) {
      const double phase = std::fmod(230.0 * trace.time_s[i], 1.0);
      trace.power_w[i] = static_cast<float>(
          2e-8 + (phase < duty ? 1.0 : 0.0) * (static_cast<double>(trace.power_w[i]) - 2e-8));
    }
    EXPECT_EQ(drop_spikes(trace), 0) << duty;
  }
}

TEST(DropSpikes, FewSamplesOrNoneAreNoFault) {
  PowerTrace trace;
  EXPECT_EQ(drop_spikes(trace), 0);
  for (int k = 0; k < 6; ++k) {
    trace.time_s.push_back(1e-3 * k);
    trace.power_w.push_back(k == 3 ? 1.0F : 0.0F);
    trace.noise_sigma_w = 1e-3;
    trace.sample_period_s = 1e-3;
    PowerTrace some = trace;
    EXPECT_EQ(drop_spikes(some), k == 5 ? 1 : 0) << k;
  }
}

}  // namespace
}  // namespace vildar
