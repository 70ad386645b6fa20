#include "condition/flashes.h"

#include <cmath>

#include <gtest/gtest.h>

#include "condition/noise.h"
#include "core/random.h"

namespace vildar {
namespace {

constexpr double kFlashSigma_w = 1e-10;

/// A vehicle that goes by at 5 s and is gone at once, over a level with noise; 2.2e-8 W of light
/// from 30 m, 1.25e-6 W at most.
PowerTrace trace_at(double rate_hz) {
  Random random(3);
  PowerTrace trace;
  for (int k = 0; k < static_cast<int>(10.0 * rate_hz); ++k) {
    const double time_s = k / rate_hz, range_m = 30.0 * (5.0 - time_s);
    double light_w = 2e-8 + random.normal(0.0, kFlashSigma_w);
    if (range_m > 0.0) light_w += 2e-5 / (range_m * range_m + 16.0);
    trace.time_s.push_back(time_s);
    trace.power_w.push_back(static_cast<float>(light_w));
  }
  set_noise(trace);
  return trace;
}

template <typename Shape>
void add(PowerTrace& trace, double from_s, double height_w, const Shape& shape) {
  for (std::size_t i = 0; i < trace.time_s.size(); ++i)
    if (const double since_s = trace.time_s[i] - from_s; since_s >= 0.0)
      trace.power_w[i] += static_cast<float>(height_w * shape(since_s));
}

TEST(DropFlashes, ThoseOfACameraAndOfLightningGo) {
  for (const double rate_hz : {500.0, 1000.0, 10000.0})
    for (const double fades_s : {0.001, 0.004, 0.05})
      for (const double at_s : {2.0, 4.2, 4.9, 7.0}) {
        const PowerTrace clean = trace_at(rate_hz);
        PowerTrace trace = clean;
        add(trace, at_s, 1e-5, [&](double t) { return std::exp(-t / fades_s); });
        EXPECT_GT(drop_flashes(trace), 0) << rate_hz << " Hz, " << fades_s << " s, at " << at_s;
        // What is left has a fiftieth of the vehicle's own light more at most, or the noise.
        for (std::size_t i = 0, of = 0; i < trace.power_w.size(); ++i, ++of) {
          while (clean.time_s[of] != trace.time_s[i]) ++of;
          const double own_w = clean.power_w[of] - 2e-8;
          EXPECT_LT(trace.power_w[i] - clean.power_w[of], 0.02 * own_w + 12.0 * kFlashSigma_w)
              << rate_hz << " Hz, " << fades_s << " s, at " << at_s << ": " << trace.time_s[i];
        }
        EXPECT_GT(100 * trace.power_w.size(), 90 * clean.power_w.size());
      }
}

// Lamps that pulse, with the vehicle gone within half a second, or out of a beam's cut-off.
TEST(DropFlashes, LampsThatPulseStay) {
  for (const double rate_hz : {1000.0, 10000.0})
    for (const double pulses_hz : {130.0, 200.0, 217.0, 250.0})
      for (const double fades_s : {0.02, 0.1, 0.3}) {
        PowerTrace trace = trace_at(rate_hz);
        for (std::size_t i = 0; i < trace.time_s.size(); ++i) {
          const double time_s = trace.time_s[i], periods = pulses_hz * time_s + 0.3;
          const double shines = time_s < 5.0 ? 1.0 / (0.02 + std::pow(5.0 - time_s, 2))
                                             : 50.0 * std::exp((5.0 - time_s) / fades_s);
          trace.power_w[i] =
              static_cast<float>(2e-8 + kFlashSigma_w * (static_cast<double>(i % 7) - 3.0) +
                                 (periods - std::floor(periods) < 0.45 ? 2e-8 * shines : 0.0));
        }
        set_noise(trace);
        EXPECT_EQ(drop_flashes(trace), 0) << rate_hz << ", " << pulses_hz << ", " << fades_s;
      }
}

TEST(DropFlashes, StrokesOfOneLightningGoTogether) {
  PowerTrace trace = trace_at(1000.0);
  for (const double at_s : {3.0, 3.06, 3.15})
    add(trace, at_s, 1e-5, [](double t) { return std::exp(-t / 0.02); });
  EXPECT_GT(drop_flashes(trace), 200);
  for (std::size_t i = 0; i < trace.time_s.size(); ++i)
    if (trace.time_s[i] < 4.0) {
      EXPECT_LT(trace.power_w[i], 5e-8) << trace.time_s[i];
    }
}

TEST(DropFlashes, LightOfVehiclesStays) {
  for (const double rate_hz : {100.0, 1000.0, 10000.0}) {
    PowerTrace trace = trace_at(rate_hz);
    EXPECT_EQ(drop_flashes(trace), 0) << rate_hz;
    // Lamps that are switched on, seen between two posts, or pulse.
    const auto after = [&](const auto& shape) {
      PowerTrace with = trace_at(rate_hz);
      add(with, 3.0, 1e-6, shape);
      return drop_flashes(with);
    };
    EXPECT_EQ(after([](double) { return 1.0; }), 0) << rate_hz;
    EXPECT_EQ(after([](double t) { return t < 0.2 ? 1.0 : 0.0; }), 0) << rate_hz;
    for (const double duty : {0.1, 0.5, 0.9})
      EXPECT_EQ(after([&](double t) { return std::fmod(110.0 * t, 1.0) < duty ? 1.0 : 0.0; }), 0)
          << rate_hz << " Hz, " << duty;
  }
}

TEST(DropFlashes, FewSamplesOrNoneAreNoFault) {
  PowerTrace trace;
  EXPECT_EQ(drop_flashes(trace), 0);
  for (int k = 0; k < 6; ++k) {
    trace.time_s.push_back(1e-3 * k);
    trace.power_w.push_back(k == 3 ? 1.0F : 0.0F);
    trace.noise_sigma_w = 1e-3;
    trace.sample_period_s = 1e-3;
    PowerTrace some = trace;
    EXPECT_EQ(drop_flashes(some), 0) << k;
  }
}

}  // namespace
}  // namespace vildar
