#include "optics/ego_motion.h"

#include <gtest/gtest.h>

#include "core/quantity.h"

namespace vildar {
namespace {

TEST(EgoMotion, DrivesAlongTheRoadOrAsYawRatesSay) {
  EgoSite ego{{20.0, 0.0}, {}, {}};
  RoadSite road;
  const DrivenPose straight = EgoMotion(ego, road).driven({.time_s = 1.0}, 4.0);
  EXPECT_NEAR(straight.x_m, 60.0, 1e-9);
  EXPECT_EQ(straight.y_m, 0.0);
  EXPECT_NEAR(straight.way_m, 60.0, 1e-9);

  // 30 m straight, then a quarter of a circle to the right.
  road.kind = RoadKind::curved;
  road.radius_m = Uncertain{200.0, 0.0};
  road.turn = Turn::right;
  road.straight_m = 30.0;
  const EgoMotion bend(ego, road);
  const double quarter_s = (30.0 + 0.5 * kPi * 200.0) / 20.0;
  const DrivenPose turned = bend.driven({}, quarter_s);
  EXPECT_NEAR(turned.x_m, 230.0, 0.4);  // the bend begins within a step of 0.4 m
  EXPECT_NEAR(turned.y_m, -200.0, 0.4);
  EXPECT_NEAR(turned.heading_rad, -0.5 * kPi, 2e-3);
  const DrivenPose back = bend.driven(turned, 0.0);
  EXPECT_NEAR(back.x_m, 0.0, 0.4);
  EXPECT_NEAR(back.heading_rad, 0.0, 2e-3);

  ego.trace = {{0.0, 20.0, 0.1}, {2.0, 20.0, 0.3}};
  EXPECT_NEAR(EgoMotion(ego, road).driven({}, 2.0).heading_rad, 0.4, 1e-9);
}

TEST(EgoMotion, StampsThatJumpByYearsEndInTime) {
  constexpr double kYears_s = 1e9;
  const EgoSite ego{{20.0, 0.0}, {}, {{0.0, 20.0, 0.0}, {2.0, 20.0, 0.0}}};
  const EgoMotion motion(ego, RoadSite{});
  EXPECT_NEAR(motion.driven({}, kYears_s).x_m / (20.0 * kYears_s), 1.0, 1e-9);
  EXPECT_NEAR(motion.deviation(0.0, kYears_s).ahead_m / (20.0 * kYears_s), 0.0, 1e-9);
}

}  // namespace
}  // namespace vildar
