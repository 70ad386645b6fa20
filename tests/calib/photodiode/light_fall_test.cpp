#include "calib/photodiode/light_fall.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/random.h"
#include "far.h"

namespace vildar {
namespace {

const ExpectedFall kTwoLamps{{{1.000, 0.4}, {1.020, 0.6}}, 3.0};

// Two lamps whose light grows by 2 per second and goes 7 ms late.
PowerTrace trace_of(double late_s, std::uint64_t seed) {
  Random random(seed);
  PowerTrace trace;
  trace.sample_period_s = 1e-3;
  trace.noise_sigma_w = 0.01;
  for (int k = 0; k < 2000; ++k) {
    const double t_s = 1e-3 * k;
    double light_w = 0.3;
    for (const LampFall& lamp : kTwoLamps.lamps)
      if (t_s < lamp.time_s + late_s) light_w += lamp.share * std::exp(2.0 * (t_s - lamp.time_s));
    trace.time_s.push_back(t_s);
    trace.power_w.push_back(static_cast<float>(light_w + trace.noise_sigma_w * random.normal()));
  }
  return trace;
}

TEST(LightFalls, SaysHowLate) {
  for (const double late_s : {0.0, 0.0074, -0.0312}) {
    const std::vector<LightFall> falls = light_falls(trace_of(late_s, 3), kTwoLamps, 0.1);
    ASSERT_EQ(falls.size(), 1U) << late_s;
    EXPECT_LT(std::abs(falls[0].late_s - late_s), kFar * falls[0].std_s) << late_s;
    EXPECT_LT(falls[0].std_s, 1e-3);
  }
}

TEST(LightFalls, NoFurtherThanTheReachAndTheTrace) {
  EXPECT_TRUE(light_falls(trace_of(0.15, 4), kTwoLamps, 0.1).empty());
  EXPECT_EQ(light_falls(trace_of(0.15, 4), kTwoLamps, 1e9).size(), 1U);
}

TEST(LightFalls, NothingWhereTheTraceHasAGap) {
  PowerTrace trace = trace_of(0.0, 5);
  trace.time_s.erase(trace.time_s.begin() + 990, trace.time_s.begin() + 1030);
  trace.power_w.erase(trace.power_w.begin() + 990, trace.power_w.begin() + 1030);
  EXPECT_TRUE(light_falls(trace, kTwoLamps, 0.1).empty());
  EXPECT_TRUE(light_falls(PowerTrace{}, kTwoLamps, 0.1).empty());
}

TEST(LightFalls, SmoothLightDoesNot) {
  Random random(6);
  PowerTrace trace = trace_of(0.0, 6);
  for (std::size_t k = 0; k < trace.power_w.size(); ++k) {
    const double light_w = 1.0 / (1.0 + std::exp((trace.time_s[k] - 1.0) / 0.05));
    trace.power_w[k] = static_cast<float>(light_w + trace.noise_sigma_w * random.normal());
  }
  EXPECT_TRUE(light_falls(trace, kTwoLamps, 0.1).empty());
}

}  // namespace
}  // namespace vildar
