#include "estimate/wander.h"

#include <gtest/gtest.h>

namespace vildar {
namespace {

// An acceleration at the reference and one step, each seen with a sigma.
struct Seen {
  double acceleration_mps2 = 0.0, size_mps2 = 0.0, std_mps2 = 1.0;

  WanderMixture mixture(double between_s) const {
    const double weight = 1.0 / (std_mps2 * std_mps2);
    WanderNormal normal{Eigen::Matrix2d::Identity() * weight,
                        -weight * Eigen::Vector2d(acceleration_mps2, size_mps2)};
    AccelerationPrior prior{Eigen::Vector2d(1.0, 0.0), 0.0, kAccelerationVariance_m2ps4};
    normal.information(0, 0) += 1.0 / prior.variance;
    return *mix_wanders(normal, prior, Eigen::VectorXd::Zero(1), between_s, 1.0);
  }
};

TEST(Wander, WhatIsNotSeenIsAsOpenAsBeforehand) {
  constexpr double kBetween_s = 0.25, kRelative = 1e-6;
  const WanderMixture mixture = Seen{.std_mps2 = 1e5}.mixture(kBetween_s);
  // Shares and variances of a second of wandering, summed by hand.
  const double wandered = 0.4 * 0.0025 + 0.25 * 0.16 + 0.2 * 1.0 + 0.1 * 6.25 + 0.05 * 36.0;
  EXPECT_NEAR(mixture.covariance(1, 1), wandered * kBetween_s, kRelative);
  EXPECT_NEAR(mixture.covariance(0, 0), 2.25 + wandered, kRelative);
  EXPECT_NEAR(mixture.moved.norm(), 0.0, kRelative);
}

TEST(Wander, WhatIsSeenWellIsBelieved) {
  const WanderMixture mixture = Seen{-1.0, -5.0, 1e-3}.mixture(0.25);
  EXPECT_NEAR(mixture.moved[0], -1.0, 1e-5);
  EXPECT_NEAR(mixture.moved[1], -5.0, 1e-4);
  EXPECT_NEAR(mixture.covariance(1, 1), 1e-6, 1e-8);
}

TEST(Wander, ASmallStepThatNoiseExplainsIsNoise) {
  const WanderMixture mixture = Seen{0.0, 0.3, 0.3}.mixture(0.1);
  EXPECT_GT(mixture.moved[1], 0.0);
  EXPECT_LT(mixture.moved[1], 0.15);
}

}  // namespace
}  // namespace vildar
