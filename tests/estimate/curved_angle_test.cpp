#include "estimate/curved_angle.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "core/random.h"

namespace vildar {
namespace {

constexpr double kRadius_m = 40.0;

double power_on_arc_w(double beta_rad, double gamma, double m) {
  return std::pow(std::cos(0.5 * beta_rad), m) /
         std::pow(2.0 * kRadius_m * std::sin(0.5 * beta_rad), gamma);
}

TEST(CurvedAngle, InvertsTheLawOverTheWholeArc) {
  constexpr double kRelative = 1e-9;  // near pi the law is flat: the inverse loses half the digits
  for (const double m : {0.0, 3.6})
    for (double beta_rad = 0.01; beta_rad < 3.0; beta_rad += 0.1) {
      const double found_rad = arc_angle_of_power(power_on_arc_w(beta_rad, 1.21, m),
                                                  PowerLaw{1.0, 1.21, m}, Metres(kRadius_m));
      EXPECT_NEAR(found_rad / beta_rad, 1.0, kRelative) << "m " << m << " beta " << beta_rad;
    }
}

TEST(CurvedAngle, MinimisesTheSquaredErrorByBruteForce) {
  const PowerLaw law{1.0, 1.21, 0.0};
  for (const double power_w : {-0.01, 0.0, 1e-3, 0.006, 0.02, 0.5}) {
    double best_rad = 0.0, least = std::numeric_limits<double>::infinity();
    for (int i = 1; i <= 20000; ++i) {
      const double beta_rad = kPi * i / 20000.0;
      const double error = power_w - power_on_arc_w(beta_rad, 1.21, 0.0);
      if (error * error < least) {
        least = error * error;
        best_rad = beta_rad;
      }
    }
    EXPECT_NEAR(arc_angle_of_power(power_w, law, Metres(kRadius_m)), best_rad, kPi / 20000.0)
        << power_w;
  }
}

struct Samples {
  std::vector<double> time_s, power_w;
};

Samples window(double length_s, double m, double sigma_w, Random& random) {
  Samples samples;
  for (int i = 0; i < std::lround(length_s * 1000.0); ++i) {
    samples.time_s.push_back(i * 1e-3);
    samples.power_w.push_back(power_on_arc_w(0.5 * kPi - i * 1e-3, 1.21, m) +
                              sigma_w * random.normal());
  }
  return samples;
}

TEST(CurvedAngle, IsExactWithoutNoise) {
  Random random(1);
  for (const double m : {0.0, 3.6}) {
    const Samples samples = window(0.3, m, 0.0, random);
    const auto fit = std::get<CurvedAngleFit>(fit_curved_angle(
        samples.time_s, samples.power_w, PowerLaw{1.0, 1.21, m}, Metres(kRadius_m)));
    EXPECT_NEAR(fit.speed_mps, 40.0, 1e-9);
    EXPECT_NEAR(fit.angle_at_zero_rad, 0.5 * kPi, 1e-10);
    EXPECT_EQ(fit.samples_clamped, 0);
  }
}

// One radian per second on 40 m from beta = pi/2, 30 dB, windows of 0.1 s: mean accuracy 87 %.
TEST(CurvedAngle, StartAccuracyAtThirtyDecibels) {
  constexpr int kTrials = 2000;
  Random random(42);
  const double sigma_w = power_on_arc_w(0.5 * kPi, 1.21, 0.0) * std::pow(10.0, -30.0 / 20.0);
  double error_sum = 0.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Samples samples = window(0.1, 0.0, sigma_w, random);
    const auto fit = std::get<CurvedAngleFit>(fit_curved_angle(
        samples.time_s, samples.power_w, PowerLaw{1.0, 1.21, 0.0}, Metres(kRadius_m)));
    error_sum += std::abs(fit.angular_speed_rad_per_s - 1.0);
  }
  EXPECT_NEAR(100.0 * (1.0 - error_sum / kTrials), 87.2, 2.0);
}

TEST(CurvedAngle, ClampsAreCountedAndMissesNamed) {
  const PowerLaw law{1.0, 1.21, 0.0};
  const std::vector<double> t_s{0.0, 0.1, 0.2, 0.3};
  const double p_w = power_on_arc_w(1.0, 1.21, 0.0);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto fit = std::get<CurvedAngleFit>(
      fit_curved_angle(t_s, std::vector{p_w, -p_w, p_w, nan}, law, Metres(kRadius_m)));
  EXPECT_EQ(fit.samples_clamped, 1);
  EXPECT_EQ(fit.samples_outside, 1);
  EXPECT_EQ(fit.samples_used, 3);
  EXPECT_EQ(std::get<Miss>(fit_curved_angle(t_s, std::vector(4, -1.0), law, Metres(kRadius_m))),
            Miss::below_noise);
  EXPECT_EQ(std::get<Miss>(
                fit_curved_angle(std::vector(4, 1.0), std::vector(4, p_w), law, Metres(kRadius_m))),
            Miss::no_time_spread);
  EXPECT_EQ(std::get<Miss>(fit_curved_angle({}, {}, law, Metres(kRadius_m))),
            Miss::too_few_samples);
}

}  // namespace
}  // namespace vildar
