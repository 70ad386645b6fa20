#include "optics/yaw_rate_errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/quantity.h"
#include "core/random.h"

namespace vildar {
namespace {

constexpr double kStep_s = 0.1, kNoise_rad_per_s = 0.002;

EgoSite drive(Random& random, double noise_rad_per_s) {
  EgoSite ego{{20.0, 0.1}, {}, {}};
  for (double t_s = 0.0; t_s < 12.0; t_s += kStep_s)
    ego.trace.push_back(
        {t_s, 20.0, 0.05 * std::sin(kPi * t_s / 4.0) + noise_rad_per_s * random.normal()});
  return ego;
}

TEST(YawRateErrors, NoiseIsToldFromTurns) {
  Random random(5);
  EXPECT_NEAR(yaw_rate_noise_rad_per_s(drive(random, kNoise_rad_per_s).trace), kNoise_rad_per_s,
              0.25 * kNoise_rad_per_s);
  EXPECT_LT(yaw_rate_noise_rad_per_s(drive(random, 0.0).trace), 1e-5);
  EXPECT_EQ(yaw_rate_noise_rad_per_s({}), 0.0);
}

// The sum of 60 samples' noise, 10000 times: its variance since the watch began.
TEST(YawRateErrors, WalkAsTheSumOfTheNoise) {
  Random random(6);
  const EgoSite ego = drive(random, kNoise_rad_per_s);
  const double noise_rad_per_s = yaw_rate_noise_rad_per_s({ego.trace.data() + 20, 61});
  const YawRateErrors errors(ego, {2.0, 8.0});
  for (const double time_s : {3.0, 5.0, 7.5}) {
    double variance = 0.0, summed = 0.0;
    const YawRateErrors::Values heading = errors.heading_at(time_s);
    for (int walk = 1; walk < YawRateErrors::kCount; ++walk)
      variance += std::pow(heading[walk] * errors.errors()[static_cast<std::size_t>(walk)].std, 2);
    constexpr int kTrials = 10000;
    for (int trial = 0; trial < kTrials; ++trial) {
      double turned_rad = 0.0;
      for (double t_s = 2.0; t_s < time_s; t_s += kStep_s)
        turned_rad += kStep_s * noise_rad_per_s * random.normal();
      summed += turned_rad * turned_rad / kTrials;
    }
    // Six curves leave 3 % of the walk's mean variance over the time out.
    EXPECT_NEAR(variance, summed, 0.12 * summed) << time_s;
  }
  EXPECT_EQ(errors.heading_at(3.0)[0] - errors.heading_at(2.0)[0], 1.0);
}

TEST(YawRateErrors, WayIsTheIntegralOfTheHeading) {
  Random random(7);
  const YawRateErrors errors(drive(random, kNoise_rad_per_s), {2.0, 8.0});
  constexpr double kSmall_s = 1e-4;
  for (const double time_s : {1.0, 2.5, 6.0, 9.0}) {
    const YawRateErrors::Values slope =
        (errors.way_s(time_s + kSmall_s) - errors.way_s(time_s - kSmall_s)) / (2.0 * kSmall_s);
    EXPECT_LT((slope - errors.heading_at(time_s)).abs().maxCoeff(), 1e-4) << time_s;
  }
}

}  // namespace
}  // namespace vildar
