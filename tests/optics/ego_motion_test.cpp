#include "optics/ego_motion.h"

#include <gtest/gtest.h>

namespace vildar {
namespace {

TEST(EgoMotion, TurnsWithTheRoadOrAsYawRatesSay) {
  EgoSite ego{{20.0, 0.0}, {}, {}};
  RoadSite road;
  EXPECT_EQ(EgoMotion(ego, road).turn_rate_rad_per_s(1.0, 20.0), 0.0);
  road.kind = RoadKind::curved;
  road.radius_m = Uncertain{200.0, 0.0};
  road.turn = Turn::right;
  road.straight_m = 30.0;
  EXPECT_EQ(EgoMotion(ego, road).turn_rate_rad_per_s(1.0, 20.0), 0.0);
  EXPECT_DOUBLE_EQ(EgoMotion(ego, road).turn_rate_rad_per_s(2.0, 40.0), -0.1);
  ego.trace = {{0.0, 20.0, 0.1}, {2.0, 20.0, 0.3}};
  EXPECT_DOUBLE_EQ(EgoMotion(ego, road).turn_rate_rad_per_s(1.0, 20.0), 0.2);
}

}  // namespace
}  // namespace vildar
