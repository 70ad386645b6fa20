#include "track/road_view.h"

#include <gtest/gtest.h>

#include "optics/road.h"
#include "scene.h"

namespace vildar {
namespace {

// The pair's own projection is the truth: separation and elevation then agree, chi2 is nought.
TEST(RoadView, FitPairRecoversDepthOfAProjectedPair) {
  for (const double yaw_deg : {-12.0, 0.0, 20.0}) {
    Site site = scene::site_of(5.0, -6.0, 1400.0, 1920, 1080);
    site.camera->yaw_rad.mean = radians_from_degrees(yaw_deg);
    site.camera->roll_rad.mean = radians_from_degrees(3.0);
    const RoadView view(site);
    const Camera camera(*site.camera);
    for (const double x_m : {20.0, 50.0, 120.0}) {
      const Eigen::Vector3d middle_m(x_m, -4.0, view.lamp_height_m());
      const Eigen::Vector3d half_m(0.0, 0.5 * view.separation_m(), 0.0);
      const auto left_px = view.spot_from_pixel(*camera.project(middle_m + half_m));
      const auto right_px = view.spot_from_pixel(*camera.project(middle_m - half_m));
      ASSERT_TRUE(left_px && right_px);
      const PairFit fit = view.fit_pair(*left_px, *right_px, 0.5);
      const double depth_m = (camera.camera_from_road() * (middle_m - camera.position_m())).z();
      // The pair's tilt in depth enters to second order only: (1.25 / 20)^2 at most.
      EXPECT_NEAR(fit.inverse_depth_per_m * depth_m, 1.0, 0.005) << x_m << " " << yaw_deg;
      EXPECT_LT(fit.chi2, 0.1);
      const Eigen::Vector2d between_px = 0.5 * (*left_px + *right_px);
      EXPECT_NEAR(view.road_at(between_px, fit.inverse_depth_per_m).lateral_m, -4.0, 0.1);
      EXPECT_GT(view.fit_pair(*left_px, *right_px + 3.0 * (*right_px - *left_px), 0.5).chi2, 20.0);
    }
  }
}

TEST(RoadView, FlowIsTheDerivativeOfTheProjection) {
  const Site site = scene::site_of(5.0, -6.0, 1400.0, 1920, 1080);
  const RoadView view(site);
  const Camera camera(*site.camera);
  const Eigen::Vector3d at_m(40.0, -4.0, view.lamp_height_m());
  constexpr double kStep_m = 1e-4;
  const auto spot = [&](const Eigen::Vector3d& point_m) {
    return *view.spot_from_pixel(*camera.project(point_m));
  };
  const LampPlace place = view.place(spot(at_m));
  const auto flow = [&](const Eigen::Vector3d& way) {
    return Eigen::Vector2d((spot(at_m + kStep_m * way) - spot(at_m - kStep_m * way)) /
                           (2 * kStep_m));
  };
  EXPECT_LT((flow(-Eigen::Vector3d::UnitX()) - place.inverse_depth_per_m * place.toward_px).norm(),
            1e-4);
  EXPECT_LT((flow(Eigen::Vector3d::UnitY()) - place.inverse_depth_per_m * place.across_px).norm(),
            1e-4);
  EXPECT_LT((flow(-Eigen::Vector3d::UnitZ()) - place.inverse_depth_per_m * place.down_px).norm(),
            1e-4);
}

// The projection by a camera whose heading is that much farther to the left.
TEST(RoadView, TurningMovesASpotAsTheProjectionDoes) {
  constexpr double kRate_rad_per_s = 0.2, kTurned_rad = 1e-5;
  Site site = scene::site_of(1.3, 0.0, 1000.0, 1280, 720);
  site.camera->pitch_rad.mean = 0.05;
  site.camera->roll_rad.mean = -0.03;
  site.ego = EgoSite{Uncertain{0.0, 0.1}, "ego.csv", {{0.0, 15.0, kRate_rad_per_s}}};
  const RoadView view(site);
  for (const Eigen::Vector3d& at_m : {Eigen::Vector3d(40.0, -4.0, 0.7), {15.0, 6.0, 3.0}}) {
    const auto spot_turned_by = [&](double left_rad) {
      CameraSite turned = *site.camera;
      turned.yaw_rad.mean += left_rad;
      return *view.spot_from_pixel(*Camera(turned).project(at_m));
    };
    const Eigen::Vector2d moved_px = spot_turned_by(kTurned_rad) - spot_turned_by(-kTurned_rad);
    EXPECT_LT((view.turning_pxps(spot_turned_by(0.0), 1.0) -
               kRate_rad_per_s / (2.0 * kTurned_rad) * moved_px)
                  .norm(),
              1e-3);
  }
  site.ego.reset();
  EXPECT_TRUE(RoadView(site).turning_pxps({100.0, 50.0}, 1.0).isZero());
}

TEST(RoadView, OnABendTheLanesTellHowAFarPairIsTurned) {
  Site site = scene::site_of(1.3, 0.0, 1400.0, 1920, 1080);
  site.camera->pitch_rad = {};
  site.road.kind = RoadKind::curved;
  site.road.turn = Turn::left;
  site.road.straight_m.mean = 0.0;
  site.road.radius_m = Uncertain{120.0, 0.0};
  site.road.lanes = {{"own", {0.0, 0.3}, 3.5, Direction::receding},
                     {"other", {3.5, 0.3}, 3.5, Direction::oncoming}};
  const RoadView view(site);
  const Camera camera(*site.camera);
  const PathPoint<double> at = path_point(50.0, 3.5, 1.0, 0.0, 120.0);
  // A car with lamps as high as the camera: by its elevation it is as far as can be.
  const Eigen::Vector3d lamp_m(at.x_m, at.y_m, 1.2);
  const auto spot_px = view.spot_from_pixel(*camera.project(lamp_m));
  ASSERT_TRUE(spot_px);
  const LampPlace place = view.place(*spot_px);
  const Eigen::Vector3d ray(spot_px->x() / view.focal_px(), spot_px->y() / view.focal_px(), 1.0);
  const auto flow_px = [&](const Eigen::Vector3d& way) -> Eigen::Vector2d {
    const Eigen::Vector3d seen = camera.camera_from_road() * way;
    return view.focal_px() * (seen.head<2>() - seen.z() * ray.head<2>());
  };
  const Eigen::Vector2d across_px =
      flow_px({-std::sin(at.heading_rad), std::cos(at.heading_rad), 0.0});
  EXPECT_NEAR(place.across_px.x() / across_px.x(), 1.0, 0.1);
}

TEST(RoadView, SpotOfAPlaceOnTheRoad) {
  for (const bool bends : {false, true}) {
    Site site = scene::site_of(5.0, -6.0, 1400.0, 1920, 1080);
    if (bends) {
      site.road.kind = RoadKind::curved;
      site.road.turn = Turn::left;
      site.road.straight_m.mean = 20.0;
      site.road.radius_m = Uncertain{150.0, 1.0};
    }
    const RoadView view(site);
    const Camera camera(*site.camera);
    // On the bend a quarter of a radian round the centre at (20, 150), 4 m outside of y = 0.
    const double turned_rad = 0.25, outside_m = 154.0;
    const RoadPosition at{bends ? 20.0 + outside_m * turned_rad : 58.5, -4.0};
    const Eigen::Vector3d point_m =
        bends ? Eigen::Vector3d(20.0 + outside_m * std::sin(turned_rad),
                                150.0 - outside_m * std::cos(turned_rad), view.lamp_height_m())
              : Eigen::Vector3d(58.5, -4.0, view.lamp_height_m());
    const auto spot_px = view.spot_at(at);
    ASSERT_TRUE(spot_px);
    EXPECT_NEAR((*spot_px - *view.spot_from_pixel(*camera.project(point_m))).norm(), 0.0, 1e-6);
  }
  EXPECT_FALSE(RoadView(scene::site_of(5.0, -6.0, 1400.0, 1920, 1080)).spot_at({-1.0, -4.0}));
}

TEST(RoadView, LanesAndEgoSpeed) {
  Site site = scene::site_of(5.0, -6.0, 1400.0, 1920, 1080);
  EXPECT_EQ(RoadView(site).beyond_lanes_m(50.0), 0.0);
  site.road.lanes = {{"a", {-4.0, 0.0}, 3.0, Direction::oncoming},
                     {"b", {2.0, 0.0}, 4.0, Direction::receding}};
  site.ego = EgoSite{Uncertain{}, {}, {{1.0, 10.0, 0.0}, {3.0, 14.0, 0.0}}};
  const RoadView view(site);
  EXPECT_DOUBLE_EQ(view.beyond_lanes_m(-7.5), 2.0);
  EXPECT_DOUBLE_EQ(view.beyond_lanes_m(-1.0), 0.0);
  EXPECT_DOUBLE_EQ(view.beyond_lanes_m(5.0), 1.0);
  EXPECT_DOUBLE_EQ(*view.off_lane_centre_m(1.0), 1.0);
  EXPECT_DOUBLE_EQ(view.ego_speed_mps(0.0), 10.0);
  EXPECT_DOUBLE_EQ(view.ego_speed_mps(2.5), 13.0);
  EXPECT_DOUBLE_EQ(view.ego_speed_mps(9.0), 14.0);
}

// It brakes at 2 m/s^2 from 14 m/s: in two seconds 4 m less than at 14 m/s.
TEST(RoadView, TellsHowMuchFartherItDroveThanAtItsFirstSpeed) {
  Site site = scene::site_of(1.3, 0.0, 1000.0, 1280, 720);
  site.ego = EgoSite{Uncertain{0.0, 0.1}, "ego.csv", {{0.0, 14.0, 0.0}, {5.0, 4.0, 0.0}}};
  const RoadView braking(site);
  EXPECT_NEAR(braking.speeding_up_m(1.0, 3.0), -4.0, 1e-6);
  site.ego = EgoSite{Uncertain{14.0, 0.1}, {}, {}};
  EXPECT_EQ(RoadView(site).speeding_up_m(1.0, 3.0), 0.0);
}

}  // namespace
}  // namespace vildar
