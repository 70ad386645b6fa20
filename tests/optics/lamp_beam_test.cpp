#include "optics/lamp_beam.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "core/quantity.h"
#include "core/random.h"
#include "toward.h"

namespace vildar {
namespace {

TEST(LampBeam, ALambertianLampSendsOutItsClosedFormFlux) {
  constexpr double kQuadrature = 1e-4;
  for (const double order : {1.0, 2.6008, 20.0}) {
    const LampBeam beam(LambertianBeam{1000.0, order});
    EXPECT_NEAR(beam.flux_lm() / (2.0 * kPi * 1000.0 / (order + 1.0)), 1.0, kQuadrature) << order;
    EXPECT_NEAR(toward(beam, 30.0, 0.0), 1000.0 * std::pow(0.75, 0.5 * order), 1e-9);
    EXPECT_NEAR(toward(beam, 0.0, -30.0), toward(beam, 30.0, 0.0), 1e-9);
    EXPECT_EQ(toward(beam, 180.0, 10.0), 0.0);
  }
}

TEST(LampBeam, TheFluxOfANarrowEdgeIsIntegratedToItsLimit) {
  // Brute force on an even grid of 0.02 degrees over the core, coarser outside.
  const LampBeam beam{LowBeam{}};
  double flux_lm = 0.0;
  const auto add = [&](double low_deg, double high_deg, double floor_deg, double top_deg,
                       double step_deg) {
    for (double az = low_deg + 0.5 * step_deg; az < high_deg; az += step_deg)
      for (double el = floor_deg + 0.5 * step_deg; el < top_deg; el += step_deg)
        flux_lm += toward(beam, az, el) * std::cos(radians_from_degrees(el)) *
                   radians_from_degrees(step_deg) * radians_from_degrees(step_deg);
  };
  add(-12.0, 12.0, -3.0, 3.0, 0.04);
  add(-90.0, -12.0, -90.0, 90.0, 0.25);
  add(12.0, 90.0, -90.0, 90.0, 0.25);
  add(-12.0, 12.0, 3.0, 90.0, 0.25);
  add(-12.0, 12.0, -90.0, -3.0, 0.25);
  EXPECT_NEAR(beam.flux_lm() / flux_lm, 1.0, 2e-4);
  EXPECT_GT(flux_lm, 350.0);  // what tungsten and LED passing beams put out
  EXPECT_LT(flux_lm, 900.0);
}

TEST(LampBeam, AimTurnsTheBeamAndScaleMultipliesIt) {
  const LambertianBeam shape{500.0, 40.0};
  const LampBeam aimed(shape, {radians_from_degrees(7.0), radians_from_degrees(-3.0), 0.0}, 2.0);
  EXPECT_NEAR(toward(aimed, 7.0, -3.0), 1000.0, 1e-6);
  EXPECT_NEAR(aimed.flux_lm(), 2.0 * LampBeam(shape).flux_lm(), 1e-9);
  // A beam that is rolled a quarter clockwise sends right what it sent up.
  const LampBeam upright{LowBeam{}};
  const LampBeam rolled(LowBeam{}, {0.0, 0.0, radians_from_degrees(90.0)});
  EXPECT_NEAR(toward(rolled, 1.5, 0.0), toward(upright, 0.0, -1.5), 1e-6);
}

TEST(LampBeam, TheLengthOfADirectionDoesNotMatter) {
  const LampBeam beam{HighBeam{}};
  EXPECT_NEAR(beam.intensity_cd(Eigen::Vector3d(50.0, 2.0, -0.5)),
              beam.intensity_cd(std::atan2(2.0, 50.0), std::atan2(-0.5, std::hypot(50.0, 2.0))),
              1e-6);
}

TEST(LampBeam, AVehicleThatComesShinesBackAlongTheRoad) {
  // Heading -x, sensor at the origin side: ahead in its axes; the road's left is its right.
  const Eigen::Vector3d ahead = vehicle_from_road({-10.0, 0.0, 0.0}, kPi, 0.0);
  EXPECT_NEAR((ahead - Eigen::Vector3d(10.0, 0.0, 0.0)).norm(), 0.0, 1e-12);
  const Eigen::Vector3d aside = vehicle_from_road({-10.0, 1.0, 0.0}, kPi, 0.0);
  EXPECT_NEAR(aside.y(), -1.0, 1e-12);
  // Nose up: what was level ahead now lies below the axis.
  EXPECT_NEAR(vehicle_from_road({1.0, 0.0, 0.0}, 0.0, 0.01).z(), -std::sin(0.01), 1e-12);
}

TEST(LampBeam, LeftHandTrafficHasTheMirrorImage) {
  const LampBeam right{LowBeam{TrafficSide::right}}, left{LowBeam{TrafficSide::left}};
  Random random(11);
  for (int i = 0; i < 200; ++i) {
    const double left_deg = random.uniform(-60.0, 60.0), up_deg = random.uniform(-20.0, 20.0);
    EXPECT_NEAR(toward(right, left_deg, up_deg), toward(left, -left_deg, up_deg), 1e-6);
  }
}

TEST(LampBeam, EveryBeamIsFiniteDarkBehindAndNeverNegative) {
  Random random(12);
  for (const LampBeam& beam :
       {LampBeam{LowBeam{}}, LampBeam{HighBeam{}}, LampBeam{kDaytimeRunningLamp},
        LampBeam{kTailLamp}, LampBeam{LambertianBeam{}}})
    for (int i = 0; i < 500; ++i) {
      const double left_deg = random.uniform(-180.0, 180.0), up_deg = random.uniform(-90.0, 90.0);
      const double intensity_cd = toward(beam, left_deg, up_deg);
      ASSERT_TRUE(std::isfinite(intensity_cd));
      ASSERT_GE(intensity_cd, 0.0);
      if (std::abs(left_deg) > 90.0) {
        ASSERT_NEAR(intensity_cd, 0.0, 1e-9);
      }
    }
}

TEST(LampBeam, ANegativeScaleAndAMissingTableAreRefused) {
  EXPECT_THROW(LampBeam(LowBeam{}, {}, -1.0), std::invalid_argument);
  EXPECT_THROW(LampBeam(TableBeam{}), std::invalid_argument);
}

}  // namespace
}  // namespace vildar
