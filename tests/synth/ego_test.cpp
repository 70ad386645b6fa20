#include "synth/ego.h"

#include <cmath>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/quantity.h"
#include "optics/camera.h"
#include "scenes.h"
#include "synth/truth.h"

namespace vildar {
namespace {

Site dashcam(std::vector<EgoSample> trace) {
  Site site;
  site.ego.emplace();
  site.ego->trace = std::move(trace);
  return site;
}

TEST(EgoPose, AConstantTurnIsACircle) {
  const EgoPose pose = ego_pose(dashcam({{0.0, 12.0, 0.3}, {10.0, 12.0, 0.3}}), 4.0);
  constexpr double kRadius_m = 12.0 / 0.3;
  EXPECT_NEAR(pose.heading_rad, 1.2, 1e-12);
  // Chords instead of arcs: (turn per step)^2 / 24 of the way.
  EXPECT_NEAR(pose.place_m.x(), kRadius_m * std::sin(1.2), 1e-4);
  EXPECT_NEAR(pose.place_m.y(), kRadius_m * (1.0 - std::cos(1.2)), 1e-4);
  const Eigen::Vector2d point_m(50.0, 7.0);
  EXPECT_LT((pose.still_m(pose.seen_m(point_m)) - point_m).norm(), 1e-12);
  // A point straight ahead is seen on the x axis.
  const Eigen::Vector2d ahead_m =
      pose.seen_m(pose.place_m + 9.0 * Eigen::Vector2d(std::cos(1.2), std::sin(1.2)));
  EXPECT_LT((ahead_m - Eigen::Vector2d(9.0, 0.0)).norm(), 1e-12);
}

TEST(EgoPose, ATraceThatSpeedsUpCoversTheAreaUnderIt) {
  const Site site = dashcam({{0.0, 10.0, 0.0}, {2.0, 20.0, 0.0}});
  EXPECT_NEAR(ego_pose(site, 2.0).place_m.x(), 30.0, 1e-9);
  EXPECT_NEAR(ego_pose(site, 3.0).place_m.x(), 50.0, 1e-9) << "the last speed is held";
}

TEST(EgoPose, WithoutYawRatesTheRoadIsFollowed) {
  Site site = dashcam({{0.0, 10.0, 0.0}, {2.0, 20.0, 0.0}});
  site.road.kind = RoadKind::curved;
  site.road.turn = Turn::right;
  site.road.radius_m = Uncertain{80.0, 0.0};
  const EgoPose pose = ego_pose(site, 2.0);
  EXPECT_NEAR(pose.heading_rad, -30.0 / 80.0, 1e-12);
  EXPECT_NEAR(pose.place_m.x(), 80.0 * std::sin(30.0 / 80.0), 1e-9);
  EXPECT_NEAR(pose.place_m.y(), -80.0 * (1.0 - std::cos(30.0 / 80.0)), 1e-9);
}

TEST(Truth, OfADashcamIsRelativeInPlaceAndOverGroundInSpeed) {
  Scenario scene = small_scene();
  scene.site.camera->position_m[2].mean = 1.3;
  scene.site.camera->pitch_rad.mean = -0.02;
  scene.site.ego = EgoSite{{15.0, 0.0}, {}, {}};
  scene.site.road.lanes[0].lateral_m.mean = 3.5;
  scene.vehicles = {car_at(90.0, 20.0)};
  for (const TruthTrackRow& row : truth_tracks(scene)) {
    EXPECT_NEAR(row.place_m.x(), 90.0 - 35.0 * row.time_s, 1e-9);
    EXPECT_NEAR(row.place_m.y(), 3.5, 1e-12);
    EXPECT_DOUBLE_EQ(row.speed_mps, 20.0);
  }
}

TEST(CameraShake, IsTheCameraTurnedThatMuch) {
  Scenario scene = small_scene();
  CameraSite& camera = *scene.site.camera;
  camera.yaw_rad.mean = camera.pitch_rad.mean = 0.0;
  scene.shake = {0.004, 0.007, 2.0};
  const CameraShake shake(scene);
  const Eigen::Vector3d point_m(30.0, -3.0, 0.65);
  const Camera steady(camera);
  for (const double time_s : {0.1, 0.77, 2.3}) {
    CameraSite turned = camera;
    turned.yaw_rad.mean = shake.turn_rad(time_s)[0];
    turned.pitch_rad.mean = shake.turn_rad(time_s)[1];
    const auto expected_px = Camera(turned).project(point_m);
    const auto got_px = steady.project(shake.steady_m(point_m, time_s));
    ASSERT_TRUE(expected_px && got_px);
    EXPECT_LT((*expected_px - *got_px).norm(), 1e-9);
  }
}

TEST(CameraShake, HasTheSpreadAskedForAndTheSeedOfTheScene) {
  Scenario scene = small_scene();
  scene.shake = {0.004, 0.007, 2.0};
  const CameraShake shake(scene);
  Eigen::Vector2d square = Eigen::Vector2d::Zero();
  constexpr int kTimes = 20'000;
  for (int i = 0; i < kTimes; ++i) square += shake.turn_rad(i * 0.05).cwiseAbs2();
  EXPECT_NEAR(std::sqrt(square[0] / kTimes), 0.004, 1e-4);  // 2000 beats of five sines
  EXPECT_NEAR(std::sqrt(square[1] / kTimes), 0.007, 2e-4);
  scene.seed = 8;
  EXPECT_NE(CameraShake(scene).turn_rad(1.0), shake.turn_rad(1.0));
}

}  // namespace
}  // namespace vildar
