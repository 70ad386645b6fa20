#include "calib/photodiode/rim_crossing.h"

#include <cmath>

#include <gtest/gtest.h>

#include "far.h"
#include "simulated_rims.h"

namespace vildar {
namespace {

struct Scene {
  Site site = simulated::rim_site({});
  simulated::Vehicle vehicle;
  Trajectory way;

  PhotodiodeSite& photodiode() { return site.photodiodes[0]; }
  void follow(double to_s) {
    Random random(11);
    std::vector<std::string> warnings;
    auto fitted = fit_trajectories(simulated::track_of(vehicle, site, {.to_s = to_s}, random),
                                   Camera(*site.camera), site, warnings);
    way = std::get<std::vector<Trajectory>>(fitted).front();
  }
  // When the lamp leaves the view, by the simulator.
  double leaves_s(double side) {
    for (double t_s = 0.0;; t_s += 1e-5) {
      const simulated::Lamps lamps = simulated::lamps_at(vehicle, site.road, t_s);
      const Eigen::Vector3d apart_m =
          (side > 0.0 ? lamps.left_m : lamps.right_m) - simulated::stands_at_m(photodiode());
      if (std::acos(apart_m.normalized().dot(simulated::looks_along(photodiode()))) >
          photodiode().half_field_of_view_rad)
        return t_s;
    }
  }
  void expect_told(double largest_std_s) {
    for (const double side : {-0.5, 0.5}) {
      const auto crossing = rim_crossing(way, side, photodiode());
      ASSERT_TRUE(crossing);
      EXPECT_LT(std::abs(crossing->time_s - leaves_s(side)), kFar * crossing->std_s);
      EXPECT_LT(crossing->std_s, largest_std_s);
    }
  }
};

TEST(RimCrossing, IsWhenTheLampsLeaveTheView) {
  Scene scene;
  scene.vehicle.acceleration_mps2 = -1.0;
  scene.follow(2.5);
  scene.expect_told(0.015);
  // The farther lamp goes first.
  EXPECT_LT(rim_crossing(scene.way, -0.5, scene.photodiode())->time_s,
            rim_crossing(scene.way, 0.5, scene.photodiode())->time_s);
}

TEST(RimCrossing, OnABend) {
  Scene scene;
  scene.site.road.kind = RoadKind::curved;
  scene.site.road.turn = Turn::right;
  scene.site.road.radius_m = Uncertain{60.0, 3.0};
  scene.vehicle.along_m = 45.0;
  scene.vehicle.speed_mps = 12.0;
  scene.follow(2.8);
  scene.expect_told(0.04);
}

TEST(RimCrossing, WithinTheCamerasViewIsToldBest) {
  Scene scene;
  scene.photodiode().half_field_of_view_rad = radians_from_degrees(12.0);
  scene.follow(2.5);
  scene.expect_told(0.01);
}

TEST(RimCrossing, MovesWithTheRim) {
  constexpr double kStep_rad = 1e-3;
  Scene scene;
  scene.follow(2.5);
  const auto crossing = rim_crossing(scene.way, 0.5, scene.photodiode());
  scene.photodiode().half_field_of_view_rad += kStep_rad;
  const auto wider = rim_crossing(scene.way, 0.5, scene.photodiode());
  ASSERT_TRUE(crossing && wider);
  EXPECT_NEAR((wider->time_s - crossing->time_s) / kStep_rad, crossing->by_half_view_s_per_rad,
              0.02 * crossing->by_half_view_s_per_rad);
}

TEST(RimCrossing, NothingWhereTheLampIsNotSeen) {
  Scene scene;
  scene.follow(2.5);
  scene.photodiode().yaw_rad = radians_from_degrees(100.0);
  EXPECT_FALSE(rim_crossing(scene.way, 0.5, scene.photodiode()));
}

}  // namespace
}  // namespace vildar
