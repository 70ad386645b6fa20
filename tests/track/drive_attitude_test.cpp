#include "track/drive_attitude.h"

#include <cmath>

#include <gtest/gtest.h>

#include "drive_past_lamps.h"

namespace vildar {
namespace {

using drive::Drive;

Site site_of(const Drive& drive) {
  Site site;
  CameraSite camera;
  camera.width_px = 640;
  camera.height_px = 360;
  camera.focal_px = {drive::kFocal_px, drive::kFocal_px};
  camera.principal_px = {319.5, 179.5};
  camera.position_m[2].mean = drive::kCameraHeight_m;
  camera.pitch_rad = {-0.035, 0.002};
  camera.yaw_rad.std = 0.005;
  site.camera = camera;
  site.ego = EgoSite{{drive::kSpeed_mps, 0.1}, {}, {}};
  if (drive.curvature_per_m != 0.0) {
    site.road.kind = RoadKind::curved;
    site.road.turn = drive.curvature_per_m > 0.0 ? Turn::left : Turn::right;
    site.road.radius_m = Uncertain{1.0 / std::abs(drive.curvature_per_m), 0.0};
  }
  return site;
}

struct Driven {
  Drive drive;
  DriveAttitude attitude;

  explicit Driven(const Drive& given, std::uint64_t seed = 7)
      : drive(given), attitude(site_of(given)) {
    Random random(seed);
    const TurnProblem seen = drive.seen(random);
    for (std::size_t frame = 0; frame < seen.frames; ++frame) {
      attitude.begin(static_cast<std::int64_t>(frame),
                     static_cast<double>(frame) / drive::kRate_hz);
      for (const PassedLight& one : seen.sightings)
        if (one.frame == frame)
          attitude.add(one.light, {{static_cast<std::int64_t>(frame), drive::kFocal_px * one.at,
                                    drive::kSigma_px, one.time_s}});
    }
  }

  // Root mean square of the errors of pitch and yaw, less their means.
  double error_rad() const {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero(), squares = sum;
    double count = 0.0;
    for (std::size_t frame = 0; frame < drive::kFrames; ++frame) {
      const auto turn = attitude.at(static_cast<std::int64_t>(frame));
      if (!turn) continue;
      const Eigen::Vector2d error_rad = (turn->rotation_rad - drive.turn(frame)).head<2>();
      sum += error_rad;
      squares += error_rad.cwiseAbs2();
      count += 1.0;
    }
    return std::sqrt(0.5 * (squares / count - (sum / count).cwiseAbs2()).sum());
  }
};

Drive shaken(double curvature_per_m) {
  Random random(11);
  Drive drive;
  drive.curvature_per_m = curvature_per_m;
  drive.lights = drive::lamps_beside_the_road(random, 6, curvature_per_m);
  drive.turn = drive::swinging(random, 0.005);
  return drive;
}

TEST(DriveAttitude, TurnsAreFoundOnAStraightRoadAndOnBends) {
  for (const double curvature_per_m : {0.0, 1.0 / 150.0, -1.0 / 150.0}) {
    const Driven driven(shaken(curvature_per_m));
    ASSERT_TRUE(driven.attitude.at(50)) << curvature_per_m;
    EXPECT_LT(driven.error_rad(), 4e-4) << curvature_per_m;
  }
}

TEST(DriveAttitude, ACameraThatDoesNotShakeIsLeftAlone) {
  Drive drive = shaken(0.0);
  drive.turn = [](std::size_t) { return Eigen::Vector3d::Zero().eval(); };
  EXPECT_FALSE(Driven(drive).attitude.at(50));
}

// Seen alone, it might as well stand nearer, before a camera whose pitch drifts.
TEST(DriveAttitude, ALoneVehicleThatBrakesIsNoShaking) {
  Drive drive;
  drive.lights = {[](double time_s) {
    return Eigen::Vector3d(120.0 - 12.0 * time_s + 2.0 * time_s * time_s, 3.5, 3.5);
  }};
  EXPECT_FALSE(Driven(drive).attitude.at(50));
}

TEST(DriveAttitude, NoLightTellsNothing) { EXPECT_FALSE(Driven(Drive{}).attitude.at(50)); }

TEST(DriveAttitude, ForgottenFramesTellNothingAndTheWayGoesOn) {
  Driven driven(shaken(1.0 / 150.0));
  driven.attitude.forget_before(30);
  EXPECT_FALSE(driven.attitude.at(29));
  EXPECT_TRUE(driven.attitude.at(30));
  EXPECT_LT(driven.error_rad(), 4e-4);
}

}  // namespace
}  // namespace vildar
