#include "estimate/path_model.h"

#include <gtest/gtest.h>

#include "core/random.h"

namespace vildar {
namespace {

TEST(PathModel, TurnsTheCameraAsItsPoseSays) {
  constexpr double kExact = 1e-12;
  Random random(1);
  for (int trial = 0; trial < 20; ++trial) {
    CameraSite site;
    site.yaw_rad = {random.uniform(-0.5, 0.5), 0.05};
    site.pitch_rad.mean = random.uniform(-0.5, 0.5);
    site.roll_rad.mean = random.uniform(-0.5, 0.5);
    const PathSetting setting = path_setting(site, {});
    PathVector path = PathVector::Zero();
    for (const int axis : {kYaw, kPitch, kRoll}) path[axis] = random.uniform(-0.1, 0.1);
    const Eigen::Vector3d ray(20.0, random.uniform(-5.0, 5.0), random.uniform(-4.0, 0.0));
    const Eigen::Vector3d expected = camera_from_road_rotation(site.yaw_rad.mean + path[kYaw],
                                                               site.pitch_rad.mean + path[kPitch],
                                                               site.roll_rad.mean + path[kRoll]) *
                                     ray;
    EXPECT_LT((camera_axes(path.data(), setting, ray) - expected).norm(), kExact * ray.norm());
  }
}

// A longer lens than the site says shows all farther from the middle.
TEST(PathModel, StretchesTheViewByTheFocalLength) {
  CameraSite site;
  site.focal_px = {1400.0, 1400.0};
  site.focal_std_px = 28.0;
  const PathSetting setting = path_setting(site, {});
  PathVector path = PathVector::Zero();
  path[kLogFocal] = std::log(1.02);
  const Eigen::Vector3d ray(40.0, -3.0, -4.32);
  const Eigen::Vector3d seen = camera_axes(path.data(), setting, ray);
  EXPECT_NEAR(1400.0 * seen.x() / seen.z(), 1428.0 * 3.0 / 40.0, 1e-9);
  EXPECT_NEAR(1400.0 * seen.y() / seen.z(), 1428.0 * 4.32 / 40.0, 1e-9);
}

}  // namespace
}  // namespace vildar
