#include "synth/motion.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/quantity.h"
#include "optics/road.h"
#include "scenes.h"

namespace vildar {
namespace {

TEST(StateAt, FollowsUniformAcceleration) {
  const Scenario scene = small_scene();
  VehicleScene vehicle = car_at(60.0, 20.0);
  vehicle.acceleration_mps2 = -2.0;
  vehicle.lateral_offset_m = 0.3;
  const VehicleState state = state_at(vehicle, scene.site.road, 1.5);
  EXPECT_DOUBLE_EQ(state.place_m.x(), 60.0 - (20.0 * 1.5 - 1.5 * 1.5));
  EXPECT_DOUBLE_EQ(state.place_m.y(), -2.7);
  EXPECT_DOUBLE_EQ(state.speed_mps, 17.0);
  EXPECT_EQ(state.forward, Eigen::Vector2d(-1.0, 0.0));
}

TEST(StateAt, AVehicleThatHasStoppedStays) {
  const Scenario scene = small_scene();
  VehicleScene vehicle = car_at(60.0, 10.0);
  vehicle.acceleration_mps2 = -5.0;
  for (const double time_s : {2.0, 3.0, 100.0}) {
    const VehicleState state = state_at(vehicle, scene.site.road, time_s);
    EXPECT_DOUBLE_EQ(state.place_m.x(), 50.0) << time_s;  // v^2 / 2a gone
    EXPECT_EQ(state.speed_mps, 0.0);
    EXPECT_EQ(state.acceleration_mps2, 0.0);
  }
}

TEST(StateAt, SpeedChangesFollowEachOther) {
  const Scenario scene = small_scene();
  VehicleScene vehicle = car_at(100.0, 10.0);
  vehicle.speed_changes = {{1.0, 2.0}, {3.0, -5.0}, {8.0, 1.0}};
  // 10 m at 10 m/s; 2 s at 2 m/s^2: 24 m, to 14 m/s; 14^2 / 10 = 19.6 m to a stop at 5.8 s.
  EXPECT_NEAR(state_at(vehicle, scene.site.road, 1.0).place_m.x(), 90.0, 1e-12);
  EXPECT_NEAR(state_at(vehicle, scene.site.road, 3.0).place_m.x(), 66.0, 1e-12);
  EXPECT_NEAR(state_at(vehicle, scene.site.road, 3.0).speed_mps, 14.0, 1e-12);
  EXPECT_NEAR(state_at(vehicle, scene.site.road, 7.0).place_m.x(), 46.4, 1e-12);
  EXPECT_EQ(state_at(vehicle, scene.site.road, 7.0).speed_mps, 0.0);
  EXPECT_NEAR(state_at(vehicle, scene.site.road, 10.0).place_m.x(), 44.4, 1e-12);
  EXPECT_NEAR(state_at(vehicle, scene.site.road, 10.0).speed_mps, 2.0, 1e-12);
}

TEST(StateAt, ALaneChangeIsSmoothAndItsSpeedThatOfThePath) {
  Scenario scene = small_scene();
  for (const bool curved : {false, true}) {
    RoadSite& road = scene.site.road;
    if (curved) {
      road.kind = RoadKind::curved;
      road.radius_m = Uncertain{60.0, 0.0};
      road.straight_m.mean = 10.0;
    }
    VehicleScene vehicle = car_at(70.0, 18.0);
    vehicle.acceleration_mps2 = -1.0;
    vehicle.lane_changes = {{0.5, 2.0, 1, -3.5}};
    EXPECT_EQ(lane_at(vehicle, 1.4), 0);
    EXPECT_EQ(lane_at(vehicle, 1.6), 1);
    double length_m = 0.0, speed_sum = 0.0;
    constexpr int kSteps = 3000;
    for (int i = 0; i < kSteps; ++i) {
      const double from_s = 3.0 * i / kSteps, step_s = 3.0 / kSteps;
      const Eigen::Vector2d step_m = state_at(vehicle, road, from_s + step_s).place_m -
                                     state_at(vehicle, road, from_s).place_m;
      const VehicleState middle = state_at(vehicle, road, from_s + 0.5 * step_s);
      length_m += step_m.norm();
      speed_sum += middle.speed_mps * step_s;
      EXPECT_LT((step_m.normalized() - middle.forward).norm(), 1e-3);
    }
    EXPECT_NEAR(speed_sum, length_m, 1e-4 * length_m);
    const double lateral_m = road_position(road, state_at(vehicle, road, 3.0).place_m.x(),
                                           state_at(vehicle, road, 3.0).place_m.y())
                                 .lateral_m;
    EXPECT_NEAR(lateral_m, -6.5, 1e-9);
  }
}

TEST(PitchAt, IsASine) {
  VehicleScene vehicle;
  vehicle.pitch = {0.01, 2.0, 0.3};
  EXPECT_NEAR(pitch_rad_at(vehicle, 0.7), 0.01 * std::sin(2.0 * kPi * 1.4 + 0.3), 1e-15);
}

TEST(StateAt, TheCurveIsThePapers) {
  // R_o = d_o = 0: x = r_c sin(beta), |y| = r_c (1 - cos(beta)).
  Scenario scene = small_scene();
  RoadSite& road = scene.site.road;
  road.kind = RoadKind::curved;
  road.turn = Turn::right;
  road.radius_m = Uncertain{40.0, 0.0};
  road.lanes[0].lateral_m.mean = 0.0;
  const double beta_rad = 0.7;
  const VehicleState state = state_at(car_at(40.0 * beta_rad, 12.0), road, 0.0);
  EXPECT_NEAR(state.place_m.x(), 40.0 * std::sin(beta_rad), 1e-12);
  EXPECT_NEAR(state.place_m.y(), -40.0 * (1.0 - std::cos(beta_rad)), 1e-12);
  // Its way is the slope of the path, by differences.
  const Eigen::Vector2d step =
      state_at(car_at(40.0 * beta_rad, 12.0), road, 1e-5).place_m - state.place_m;
  EXPECT_LT((step.normalized() - state.forward).norm(), 1e-5);
  EXPECT_NEAR(step.norm(), 12.0 * 1e-5, 1e-10);
}

TEST(LampPositions, StandAcrossTheWay) {
  const Scenario scene = small_scene();
  const VehicleScene vehicle = car_at(30.0, 10.0);
  const auto lamps = lamp_positions_m(vehicle, state_at(vehicle, scene.site.road, 0.0));
  ASSERT_EQ(lamps.size(), 2u);
  // Coming toward the sensor, the vehicle's own right is the sensor's left.
  EXPECT_LT((lamps[0] - Eigen::Vector3d(30.0, -3.0 + 0.625, 0.65)).norm(), 1e-12);
  EXPECT_LT((lamps[1] - Eigen::Vector3d(30.0, -3.0 - 0.625, 0.65)).norm(), 1e-12);
  VehicleScene motorcycle = vehicle;
  motorcycle.lamp_separation_m = 0.0;
  EXPECT_EQ(lamp_positions_m(motorcycle, state_at(motorcycle, scene.site.road, 0.0)).size(), 1u);
}

TEST(LampsFace, HeadForwardTailBack) {
  const Scenario scene = small_scene();
  const Eigen::Vector3d sensor_m(0.0, 0.0, 5.0);
  VehicleScene vehicle = car_at(10.0, 10.0);
  EXPECT_TRUE(lamps_face(vehicle, state_at(vehicle, scene.site.road, 0.9), sensor_m));
  EXPECT_FALSE(lamps_face(vehicle, state_at(vehicle, scene.site.road, 1.1), sensor_m));
  vehicle.lamps = VehicleLamps::tail;
  EXPECT_FALSE(lamps_face(vehicle, state_at(vehicle, scene.site.road, 0.9), sensor_m));
  EXPECT_TRUE(lamps_face(vehicle, state_at(vehicle, scene.site.road, 1.1), sensor_m));
}

TEST(BodyHides, ALorryHidesWhatIsLowAndCloseBehind) {
  const Scenario scene = small_scene();
  VehicleScene lorry = car_at(20.0, 0.0);
  lorry.kind = VehicleKind::lorry;
  const VehicleState state = state_at(lorry, scene.site.road, 0.0);
  const Eigen::Vector3d sensor_m(0.0, 0.0, 5.0);
  const auto hides = [&](double x_m, double y_m, double z_m) {
    return body_hides(lorry, state, {x_m, y_m, z_m}, sensor_m);
  };
  EXPECT_TRUE(hides(36.0, -3.0, 0.65));
  EXPECT_FALSE(hides(36.0, 1.0, 0.65)) << "beside it";
  EXPECT_FALSE(hides(19.0, -3.0, 0.65)) << "before it";
  // The rear edge, 3.8 m high and 32 m away, casts its shadow to 32 m * 5 / 1.2 on the ground.
  EXPECT_TRUE(hides(130.0, -13.0, 0.0));
  EXPECT_FALSE(hides(136.0, -13.0, 0.0));
}

}  // namespace
}  // namespace vildar
