#include "optics/camera.h"

#include <gtest/gtest.h>

#include "core/quantity.h"
#include "optics/random_camera.h"

namespace vildar {
namespace {

CameraSite contract_camera() {
  CameraSite site;
  site.width_px = 1920;
  site.height_px = 1080;
  site.focal_px = {1400.0, 1400.0};
  site.principal_px = {959.5, 539.5};
  site.position_m = {Uncertain{0.0, 0.0}, Uncertain{0.0, 0.0}, Uncertain{5.0, 0.0}};
  site.yaw_rad.mean = radians_from_degrees(10.0);
  site.pitch_rad.mean = radians_from_degrees(-5.0);
  site.roll_rad.mean = radians_from_degrees(2.0);
  return site;
}

// The numbers are the worked check of the contract, section 1.
TEST(Camera, RotationIsTheContracts) {
  const Camera camera(contract_camera());
  Eigen::Matrix3d expected;
  expected << 0.170547, -0.984736, -0.034767, -0.091840, 0.019244, -0.995588, 0.981060, 0.172987,
      -0.087156;
  EXPECT_LT((camera.camera_from_road() - expected).cwiseAbs().maxCoeff(), 5e-7);
}

TEST(Camera, ProjectsTheContractsPoint) {
  const auto pixel = Camera(contract_camera()).project({40.0, -3.0, 0.68});
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->x(), 1314.9169, 5e-5);
  EXPECT_NEAR(pixel->y(), 559.8957, 5e-5);
}

TEST(Camera, PixelToRayToPixelComesBack) {
  constexpr double kTolerance_px = 1e-9;
  Random random(21);
  for (const auto model :
       {DistortionModel::none, DistortionModel::brown, DistortionModel::fisheye}) {
    for (int trial = 0; trial < 500; ++trial) {
      const CameraSite site = random_camera(random, model);
      const Camera camera(site);
      // Inside the middle of the image, where every lens drawn is one-to-one.
      const Eigen::Vector2d pixel_px(
          site.principal_px[0] + site.focal_px[0] * random.uniform(-0.4, 0.4),
          site.principal_px[1] + site.focal_px[1] * random.uniform(-0.3, 0.3));
      const auto ray = camera.road_ray_from_pixel(pixel_px);
      ASSERT_TRUE(ray);
      EXPECT_NEAR(ray->norm(), 1.0, 1e-12);
      const auto back_px = camera.project(camera.position_m() + random.uniform(1.0, 300.0) * *ray);
      ASSERT_TRUE(back_px);
      EXPECT_LT((*back_px - pixel_px).cwiseAbs().maxCoeff(), kTolerance_px);
    }
  }
}

TEST(Camera, NothingBehindItOrPastTheFoldOfTheLens) {
  CameraSite site = contract_camera();
  site.yaw_rad = site.pitch_rad = site.roll_rad = {};
  EXPECT_FALSE(Camera(site).project({-10.0, 0.0, 5.0}));
  EXPECT_FALSE(Camera(site).project({0.0, 1.0, 5.0}));
  // r (1 - 0.3 r^2) turns back at r = 1 / sqrt(0.9) = 1.0541, where it reaches 0.7027.
  site.distortion = DistortionModel::brown;
  site.distortion_coefficients = {-0.3, 0.0, 0.0, 0.0, 0.0};
  const Camera camera(site);
  EXPECT_TRUE(camera.project({10.0, 10.5, 5.0}));
  EXPECT_FALSE(camera.project({10.0, 10.6, 5.0}));
  EXPECT_TRUE(camera.road_ray_from_pixel({959.5 - 1400.0 * 0.70, 539.5}));
  EXPECT_FALSE(camera.road_ray_from_pixel({959.5 - 1400.0 * 0.71, 539.5}));
}

TEST(Camera, AMirroredSceneGivesMirroredPixelsAndBearings) {
  constexpr double kTolerance = 1e-9;
  Random random(22);
  for (int trial = 0; trial < 200; ++trial) {
    CameraSite site = random_camera(random, DistortionModel::brown);
    site.distortion_coefficients[3] = 0.0;  // p2 alone is not symmetric about the vertical
    site.yaw_rad.mean = random.uniform(-0.5, 0.5);
    CameraSite mirrored = site;
    mirrored.position_m[1].mean = -site.position_m[1].mean;
    mirrored.yaw_rad.mean = -site.yaw_rad.mean;
    mirrored.roll_rad.mean = -site.roll_rad.mean;
    const Camera camera(site), mirror(mirrored);
    const Eigen::Vector3d point_m =
        camera.position_m() +
        camera.camera_from_road().transpose() *
            Eigen::Vector3d(random.uniform(-6.0, 6.0), random.uniform(-4.0, 4.0), 20.0);
    const auto pixel = camera.project(point_m);
    const auto mirror_pixel = mirror.project({point_m.x(), -point_m.y(), point_m.z()});
    ASSERT_TRUE(pixel && mirror_pixel);
    EXPECT_NEAR(pixel->x() - site.principal_px[0], site.principal_px[0] - mirror_pixel->x(),
                kTolerance);
    EXPECT_NEAR(pixel->y(), mirror_pixel->y(), kTolerance);
    const auto ray = camera.road_ray_from_pixel(*pixel);
    const auto mirror_ray = mirror.road_ray_from_pixel(*mirror_pixel);
    ASSERT_TRUE(ray && mirror_ray);
    EXPECT_NEAR(bearing_of(*ray).azimuth_rad, -bearing_of(*mirror_ray).azimuth_rad, kTolerance);
    EXPECT_NEAR(bearing_of(*ray).elevation_rad, bearing_of(*mirror_ray).elevation_rad, kTolerance);
  }
}

TEST(Camera, PositiveAnglesTurnLeftTiltUpAndRollClockwise) {
  const Eigen::Vector3d forward(0.0, 0.0, 1.0), right(1.0, 0.0, 0.0);
  const auto road = [](const Eigen::Matrix3d& camera_from_road, const Eigen::Vector3d& axis) {
    return bearing_of(camera_from_road.transpose() * axis);
  };
  EXPECT_NEAR(road(camera_from_road_rotation(0.3, 0.0, 0.0), forward).azimuth_rad, 0.3, 1e-12);
  EXPECT_NEAR(road(camera_from_road_rotation(0.3, 0.2, 0.0), forward).elevation_rad, 0.2, 1e-12);
  // Clockwise from behind: the right hand goes down.
  EXPECT_NEAR(road(camera_from_road_rotation(0.0, 0.0, 0.1), right).elevation_rad, -0.1, 1e-12);
}

TEST(Camera, TheRayOfALampMeetsItsPlaneAtTheLamp) {
  Random random(23);
  const Camera camera(contract_camera());
  for (int trial = 0; trial < 100; ++trial) {
    const Eigen::Vector3d lamp_m(random.uniform(15.0, 120.0), random.uniform(-6.0, 6.0),
                                 random.uniform(0.4, 1.2));
    const auto pixel = camera.project(lamp_m);
    ASSERT_TRUE(pixel);
    const auto place_m = camera.plane_point_m(*pixel, lamp_m.z());
    ASSERT_TRUE(place_m);
    EXPECT_LT((*place_m - lamp_m.head<2>()).norm(), 1e-8);
    EXPECT_FALSE(camera.plane_point_m(*pixel, 9.0));  // above the camera: behind this ray
  }
}

}  // namespace
}  // namespace vildar
