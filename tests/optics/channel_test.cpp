#include "optics/channel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace vildar {
namespace {

TEST(Lambertian, FortyDegreesGiveThePublishedOrder) {
  EXPECT_NEAR(lambertian_order(Radians(radians_from_degrees(40.0))), 2.60078, 5e-6);
  // By definition cos^n is one half at the half-power angle; sixty degrees make it the plain
  // cosine.
  EXPECT_NEAR(lambertian_order(Radians(radians_from_degrees(60.0))), 1.0, 1e-12);
  for (const double angle_deg : {5.0, 20.0, 75.0}) {
    const double angle_rad = radians_from_degrees(angle_deg);
    EXPECT_NEAR(std::pow(std::cos(angle_rad), lambertian_order(Radians(angle_rad))), 0.5, 1e-12);
  }
}

TEST(Lambertian, AnglesOutsideTheQuarterTurnAreRefused) {
  for (const double angle_rad : {0.0, -0.1, 0.5 * kPi, 2.0, std::nan("")})
    EXPECT_THROW(lambertian_order(Radians(angle_rad)), std::domain_error) << angle_rad;
}

TEST(Lambertian, ThePapersLampLosesItsPublishedDecibelsInTheFirstMetre) {
  const double order = lambertian_order(Radians(radians_from_degrees(40.0)));
  EXPECT_NEAR(db_from_ratio(lambertian_gain(order, 1.0e-4)), -42.42, 5e-3);
}

TEST(Lambertian, TheWholeHalfSphereCatchesTheWholePower) {
  // Integral of the gain per area over the half sphere of radius 1, brute force.
  const double order = lambertian_order(Radians(radians_from_degrees(40.0)));
  constexpr int kRings = 20'000;
  double caught = 0.0;
  for (int i = 0; i < kRings; ++i) {
    const double step_rad = 0.5 * kPi / kRings;
    const double angle_rad = (i + 0.5) * step_rad;
    const double ring_m2 = 2.0 * kPi * std::sin(angle_rad) * step_rad;
    caught += lambertian_gain(order, ring_m2) * std::pow(std::cos(angle_rad), order);
  }
  EXPECT_NEAR(caught, 1.0, 1e-7);
}

TEST(Decibels, AreTenTimesTheLogarithm) {
  EXPECT_DOUBLE_EQ(ratio_from_db(-30.0), 1e-3);
  EXPECT_DOUBLE_EQ(db_from_ratio(100.0), 20.0);
}

TEST(PowerLaw, DoublingTheRangeFollowsTheExponent) {
  constexpr double kRelative = 1e-12;
  for (const double exponent : {1.21, 1.673, 2.0, 2.4}) {
    for (const double cosine_exponent : {0.0, 3.60078}) {
      const PowerLaw law{2.0e-5, exponent, cosine_exponent};
      // On the line of motion the lamp is seen head-on; the same holds when R and d both double.
      EXPECT_NEAR(law.power_w(20.0, 0.0) / law.power_w(40.0, 0.0) / std::exp2(exponent), 1.0,
                  kRelative);
      EXPECT_NEAR(law.power_w(20.0, 3.0) / law.power_w(40.0, 6.0) / std::exp2(exponent), 1.0,
                  kRelative);
    }
  }
}

TEST(PowerLaw, AThreeFourFiveTriangleByHand) {
  // R = 4, d = 3: D = 5, cos = 0.8.
  EXPECT_NEAR((PowerLaw{50.0, 2.0, 0.0}.power_w(4.0, 3.0)), 2.0, 1e-12);
  EXPECT_NEAR((PowerLaw{50.0, 2.0, 3.0}.power_w(4.0, 3.0)), 2.0 * 0.512, 1e-12);
}

TEST(PowerLaw, ShinesForwardOnlyWithTheCosineAndHasNoPlaceAtZero) {
  EXPECT_EQ((PowerLaw{1.0, 2.0, 3.6}.power_w(-4.0, 3.0)), 0.0);
  EXPECT_GT((PowerLaw{1.0, 2.0, 0.0}.power_w(-4.0, 3.0)), 0.0);
  EXPECT_THROW((PowerLaw{1.0, 2.0, 0.0}.power_w(0.0, 0.0)), std::domain_error);
  EXPECT_THROW((PowerLaw{1.0, 2.0, 0.0}.power_w(std::nan(""), 0.0)), std::domain_error);
}

}  // namespace
}  // namespace vildar
