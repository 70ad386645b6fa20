#include "optics/camera.h"

#include <gtest/gtest.h>

#include "core/quantity.h"

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

}  // namespace
}  // namespace vildar
