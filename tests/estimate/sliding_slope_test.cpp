#include "estimate/sliding_slope.h"

#include <gtest/gtest.h>

#include "estimate/power_pass.h"
#include "estimate/power_slope.h"

namespace vildar {
namespace {

using namespace power_pass;

TEST(SlidingPowerSlope, EveryWindowIsThatOfTheWholeFit) {
  constexpr std::size_t kLength = 50;
  Random random(2);
  const Samples clean = straight_window(kWindows[3], 0.0);
  std::vector<double> power = with_noise(clean.power_w, sigma_w(30.0), random);
  power[100] = -1.0;  // left out by both
  power[333] = 99.0;
  std::vector<double> time_s = clean.time_s;
  for (double& t : time_s) t += 1000.0;  // hours of running must not cost digits
  const PowerLaw law{1.0, kExponent, 0.0};
  SlidingPowerSlope sliding(law, Metres(kPerpendicular_m), kLength);
  for (std::size_t i = 0; i < power.size(); ++i) {
    sliding.push(time_s[i], power[i]);
    if (i + 1 < kLength) {
      EXPECT_FALSE(sliding.speed_mps());
      continue;
    }
    const std::size_t from = i + 1 - kLength;
    const auto whole = std::get<PowerSlopeFit>(
        fit_power_slope(std::span(time_s).subspan(from, kLength),
                        std::span(power).subspan(from, kLength), law, Metres(kPerpendicular_m)));
    ASSERT_TRUE(sliding.speed_mps());
    EXPECT_NEAR(*sliding.speed_mps(), whole.speed_mps, 1e-7 * kSpeed_mps) << i;
  }
}

TEST(SlidingPowerSlope, SaysNothingWithoutUsableSamples) {
  SlidingPowerSlope sliding(PowerLaw{1.0, 2.0, 0.0}, Metres(0.5), 3);
  for (int i = 0; i < 5; ++i) sliding.push(i, -1.0);
  EXPECT_FALSE(sliding.speed_mps());
  for (int i = 0; i < 3; ++i) sliding.push(7.0, 0.1);
  EXPECT_FALSE(sliding.speed_mps());
  EXPECT_THROW(SlidingPowerSlope(PowerLaw{0.0, 2.0, 0.0}, Metres(0.5), 3), std::domain_error);
  EXPECT_THROW(SlidingPowerSlope(PowerLaw{1.0, 2.0, 0.0}, Metres(0.5), 2), std::invalid_argument);
}

}  // namespace
}  // namespace vildar
