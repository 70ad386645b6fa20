#include "track/drive_attitude.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

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

  /// Frames before `forgotten` are forgotten in the middle of the drive.
  explicit Driven(const Drive& given, std::int64_t forgotten = 0, std::uint64_t seed = 7)
      : drive(given), attitude(site_of(given)) {
    Random random(seed);
    const TurnProblem seen = drive.seen(random);
    for (std::size_t frame = 0; frame < seen.frames; ++frame) {
      if (2 * frame == seen.frames) attitude.forget_before(forgotten);
      attitude.begin(static_cast<std::int64_t>(frame),
                     static_cast<double>(frame) / drive::kRate_hz);
      for (const PassedLight& one : seen.sightings)
        if (one.frame == frame)
          attitude.add(one.light, {{static_cast<std::int64_t>(frame), drive::kFocal_px * one.at,
                                    drive::kSigma_px, one.time_s}});
    }
  }

  std::vector<std::optional<CameraTurn>> turns(std::int64_t from = 0) const {
    std::vector<std::int64_t> frames;
    for (auto frame = from; frame < static_cast<std::int64_t>(drive.frames); ++frame)
      frames.push_back(frame);
    return attitude.turns_in(frames);
  }

  bool tells_any() const {
    return std::ranges::any_of(turns(), [](const auto& turn) { return turn.has_value(); });
  }

  // Root mean square of the errors of pitch and yaw, less their means.
  double error_rad(std::int64_t from = 0) const {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero(), squares = sum;
    const auto found = turns(from);
    for (std::size_t i = 0; i < found.size(); ++i) {
      const Eigen::Vector2d error_rad =
          (found[i].value().rotation_rad - drive.turn(static_cast<std::size_t>(from) + i))
              .head<2>();
      sum += error_rad;
      squares += error_rad.cwiseAbs2();
    }
    const auto count = static_cast<double>(found.size());
    return std::sqrt(0.5 * (squares / count - (sum / count).cwiseAbs2()).sum());
  }
};

Drive shaken(double curvature_per_m, int lights = 6) {
  Random random(11);
  Drive drive;
  drive.curvature_per_m = curvature_per_m;
  drive.lights = drive::lamps_beside_the_road(random, lights, curvature_per_m);
  drive.turn = drive::swinging(random, 0.005);
  return drive;
}

TEST(DriveAttitude, TurnsAreFoundOnAStraightRoadAndOnBends) {
  for (const double curvature_per_m : {0.0, 1.0 / 150.0, -1.0 / 150.0})
    EXPECT_LT(Driven(shaken(curvature_per_m)).error_rad(), 4e-4) << curvature_per_m;
}

// Solved in two parts, and of a street full of lights by the longest seen.
TEST(DriveAttitude, LongDrivesPastManyLightsAreSolvedToo) {
  Drive drive = shaken(0.0, 45);
  drive.frames = 700;
  EXPECT_LT(Driven(drive).error_rad(), 6e-4);
}

TEST(DriveAttitude, ACameraThatDoesNotShakeIsLeftAlone) {
  Drive drive = shaken(0.0);
  drive.turn = [](std::size_t) { return Eigen::Vector3d::Zero().eval(); };
  EXPECT_FALSE(Driven(drive).tells_any());
}

// Seen alone, it might as well stand nearer, before a camera whose pitch drifts. Noise carries its
// turns to and fro where they cross their mean.
TEST(DriveAttitude, ALoneVehicleThatBrakesIsNoShaking) {
  for (const double braking_mps2 : {2.0, 4.0, 6.0})
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
      Drive drive;
      drive.lights = {[=](double time_s) {
        return Eigen::Vector3d(120.0 - 24.0 * time_s + 0.5 * braking_mps2 * time_s * time_s, 3.5,
                               3.5);
      }};
      EXPECT_FALSE(Driven(drive, 0, seed).tells_any()) << braking_mps2 << ", " << seed;
    }
}

TEST(DriveAttitude, NoLightTellsNothing) { EXPECT_FALSE(Driven(Drive{}).tells_any()); }

TEST(DriveAttitude, ForgottenFramesTellNothingAndTheWayGoesOn) {
  const Driven driven(shaken(1.0 / 150.0), 30);
  EXPECT_FALSE(driven.turns(29).front());
  EXPECT_LT(driven.error_rad(30), 4e-4);
}

}  // namespace
}  // namespace vildar
