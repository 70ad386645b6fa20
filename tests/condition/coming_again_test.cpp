#include "condition/coming_again.h"

#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "condition/noise.h"
#include "core/random.h"

namespace vildar {
namespace {

constexpr double kAgainDark_w = 2e-8, kAgainLight_w = 1e-7, kAgainSigma_w = 5e-10;

PowerTrace lit_by(double rate_hz, const std::function<double(double)>& light) {
  Random random(3);
  PowerTrace trace;
  for (int k = 0; k < static_cast<int>(12.0 * rate_hz); ++k) {
    trace.time_s.push_back(k / rate_hz);
    trace.power_w.push_back(static_cast<float>(kAgainDark_w + kAgainLight_w * light(k / rate_hz) +
                                               random.normal(0.0, kAgainSigma_w)));
  }
  set_noise(trace);
  return trace;
}

double vehicle_light(double time_s, double at_s, double speed_mps) {
  const double ahead_m = speed_mps * (at_s - time_s);
  return ahead_m > 0.0 ? 25.0 / (ahead_m * ahead_m + 25.0) : 0.0;
}

// A filament that glows up and dies away, and one that turns.
TEST(ComingAgain, LampsThatFlashDo) {
  for (const double rate_hz : {250.0, 1000.0})
    for (const double period_s : {0.45, 0.9, 1.2}) {
      const PowerTrace flashing = lit_by(rate_hz, [&](double time_s) {
        return 1.0 / (1.0 + std::exp(-12.0 * std::sin(2.0 * kPi * time_s / period_s)));
      });
      const PowerTrace turning = lit_by(rate_hz, [&](double time_s) {
        return std::exp(20.0 * (std::cos(2.0 * kPi * time_s / period_s) - 1.0));
      });
      for (const double from_s : {0.0, 5.0}) {
        const auto flash_s = comes_again_after_s(flashing, from_s, from_s + period_s);
        const auto turn_s = comes_again_after_s(turning, from_s, from_s + period_s);
        ASSERT_TRUE(flash_s && turn_s) << rate_hz << " Hz, " << period_s << " s from " << from_s;
        EXPECT_NEAR(*flash_s, period_s, 0.01);
        EXPECT_NEAR(*turn_s, period_s, 0.01);
      }
    }
}

TEST(ComingAgain, VehiclesDoNot) {
  // Three alike a second apart, and four that are not quite as fast or as far.
  const PowerTrace three = lit_by(1000.0, [](double time_s) {
    return vehicle_light(time_s, 4.0, 20.0) + vehicle_light(time_s, 5.0, 20.0) +
           vehicle_light(time_s, 6.0, 20.0);
  });
  const PowerTrace four = lit_by(1000.0, [](double time_s) {
    return vehicle_light(time_s, 4.0, 20.0) + vehicle_light(time_s, 5.2, 21.0) +
           vehicle_light(time_s, 6.1, 19.0) + vehicle_light(time_s, 7.3, 20.0);
  });
  EXPECT_FALSE(comes_again_after_s(three, 4.05, 5.0));
  for (const double from_s : {3.2, 4.05, 5.25, 6.15})
    EXPECT_FALSE(comes_again_after_s(four, from_s, from_s + 0.85)) << from_s;
  const PowerTrace steady = lit_by(1000.0, [](double) { return 0.5; });
  EXPECT_FALSE(comes_again_after_s(steady, 5.0, 6.0));
}

}  // namespace
}  // namespace vildar
