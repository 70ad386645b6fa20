#include "optics/fresnel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace vildar {
namespace {

TEST(Fresnel, ClosedValuesAtTheThreeKnownAngles) {
  for (const double index : {1.33, 1.5, 2.4}) {
    const double ahead = (index - 1.0) / (index + 1.0);
    EXPECT_NEAR(fresnel_reflectance(1.0, index), ahead * ahead, 1e-14);
    EXPECT_NEAR(fresnel_reflectance(0.0, index), 1.0, 1e-14);
    // At Brewster's angle, tan = index, only the part polarised across is mirrored.
    const double across = (1.0 - index * index) / (1.0 + index * index);
    EXPECT_NEAR(fresnel_reflectance(1.0 / std::hypot(1.0, index), index), 0.5 * across * across,
                1e-14);
  }
  EXPECT_NEAR(fresnel_reflectance(0.3, 1.0), 0.0, 1e-14);
}

TEST(Fresnel, AgreesWithTheSineAndTangentForm) {
  for (double incidence_rad = 0.05; incidence_rad < 1.55; incidence_rad += 0.1) {
    const double inside_rad = std::asin(std::sin(incidence_rad) / kWaterIndex);
    const double across =
        std::sin(incidence_rad - inside_rad) / std::sin(incidence_rad + inside_rad);
    const double along =
        std::tan(incidence_rad - inside_rad) / std::tan(incidence_rad + inside_rad);
    EXPECT_NEAR(fresnel_reflectance(std::cos(incidence_rad), kWaterIndex),
                0.5 * (across * across + along * along), 1e-13);
  }
}

TEST(WetMirror, AFarLampIsMirroredAlmostWhole) {
  // Lamp 0.65 m and sensor 1 m high; shares rounded to two digits.
  const auto share_at = [](double range_m) {
    return wet_mirror_share(Radians(std::atan(1.65 / range_m)), 1.0);
  };
  EXPECT_NEAR(share_at(5.0), 0.16, 0.01);
  EXPECT_NEAR(share_at(11.0), 0.40, 0.01);
  EXPECT_NEAR(share_at(60.0), 0.84, 0.01);
  EXPECT_NEAR(wet_mirror_share(Radians(0.0), 0.3), 0.3, 1e-14);
  EXPECT_NEAR(wet_mirror_share(Radians(0.5 * kPi), 1.0), std::pow(0.33 / 2.33, 2), 1e-14);
}

TEST(Fresnel, NonsenseIsRefused) {
  EXPECT_THROW(fresnel_reflectance(-0.1, 1.33), std::domain_error);
  EXPECT_THROW(fresnel_reflectance(1.1, 1.33), std::domain_error);
  EXPECT_THROW(fresnel_reflectance(0.5, std::nan("")), std::domain_error);
  EXPECT_THROW(wet_mirror_share(Radians(-0.1), 1.0), std::domain_error);
  EXPECT_THROW(wet_mirror_share(Radians(0.1), 1.1), std::domain_error);
}

}  // namespace
}  // namespace vildar
