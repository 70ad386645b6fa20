#include "condition/negative_samples.h"

#include <gtest/gtest.h>

#include <cmath>

#include "condition/noise.h"
#include "core/random.h"

namespace vildar {
namespace {

constexpr double kNegativeSigma_w = 1e-9;

/// Ten seconds at 1 kHz: a level, 100 Hz flicker, noise.
PowerTrace trace_of(double level_w, double flicker_w) {
  Random random(5);
  PowerTrace trace;
  for (int k = 0; k < 10'000; ++k) {
    const double time_s = 1e-3 * k;
    const double light_w = level_w + flicker_w * std::sin(2.0 * kPi * 100.0 * time_s) +
                           random.normal(0.0, kNegativeSigma_w);
    trace.time_s.push_back(time_s);
    trace.power_w.push_back(static_cast<float>(light_w));
  }
  set_noise(trace);
  return trace;
}

TEST(DropNegative, NoiseAboutZeroStays) {
  PowerTrace trace = trace_of(0.0, 0.0);
  EXPECT_EQ(drop_negative(trace), 0);
  EXPECT_EQ(trace.power_w.size(), 10'000U);
}

TEST(DropNegative, AnAmplifierWithItsZeroTooLowStays) {
  PowerTrace trace = trace_of(-200 * kNegativeSigma_w, 0.0);
  EXPECT_EQ(drop_negative(trace), 0);
  PowerTrace flickering = trace_of(0.0, 200 * kNegativeSigma_w);
  EXPECT_EQ(drop_negative(flickering), 0) << "of a lamp whose mean was taken off";
}

TEST(DropNegative, SamplesThatNoLightGivesGo) {
  for (const double flicker_w : {0.0, 5 * kNegativeSigma_w}) {
    PowerTrace trace = trace_of(50 * kNegativeSigma_w, flicker_w);
    for (std::size_t i = 100; i < 400; ++i) trace.power_w[i] *= -1.0F;
    set_noise(trace);
    EXPECT_EQ(drop_negative(trace), 300) << flicker_w;
    EXPECT_EQ(trace.time_s.size(), 9'700U);
    EXPECT_NEAR(trace.time_s[100], 0.4, 1e-12);
  }
}

}  // namespace
}  // namespace vildar
