#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include <Eigen/Geometry>

#include "core/quantity.h"
#include "core/random.h"
#include "optics/camera.h"
#include "track/turn_solver.h"

namespace vildar::drive {

inline constexpr double kFocal_px = 530.0, kRate_hz = 25.0, kSigma_px = 0.15;
inline constexpr double kCameraHeight_m = 1.3, kSpeed_mps = 15.0, kSeconds = 4.0;
inline constexpr std::size_t kFrames = static_cast<std::size_t>(kSeconds * kRate_hz);

/// Of the camera about its own axes: right, down, forward.
using TurnAt = std::function<Eigen::Vector3d(std::size_t frame)>;
using PointAt = std::function<Eigen::Vector3d(double time_s)>;

inline TurnAt swinging(Random& random, double pitch_rad) {
  constexpr std::array<double, 5> kShares{0.41, 0.73, 1.0, 1.47, 2.13};
  const double hz = random.uniform(1.5, 4.0);
  Eigen::Array<double, 3, 5> phase;
  for (double& one : phase.reshaped()) one = random.uniform(0.0, 2.0 * kPi);
  return [=](std::size_t frame) {
    Eigen::Array3d sum = Eigen::Array3d::Zero();
    for (Eigen::Index i = 0; i < 5; ++i)
      sum += (2.0 * kPi * hz * kShares[static_cast<std::size_t>(i)] * static_cast<double>(frame) /
                  kRate_hz +
              phase.col(i))
                 .sin();
    return Eigen::Vector3d(std::sqrt(0.4) * pitch_rad * sum * Eigen::Array3d(1.0, 0.67, 0.1));
  };
}

/// Each frame's turn is as much like that of the one before.
inline TurnAt wandering(Random& random, double pitch_rad, double alike) {
  std::vector<Eigen::Vector3d> turns;
  Eigen::Vector3d unit = Eigen::Vector3d::Zero();
  for (std::size_t frame = 0; frame < kFrames; ++frame) {
    const Eigen::Vector3d fresh(random.normal(), random.normal(), random.normal());
    unit = frame == 0 ? fresh : (alike * unit + std::sqrt(1.0 - alike * alike) * fresh).eval();
    turns.push_back(pitch_rad * unit.cwiseProduct(Eigen::Vector3d(1.0, 0.67, 0.1)));
  }
  return [=](std::size_t frame) { return turns[frame]; };
}

inline Eigen::Vector2d on_road_m(double way_m, double left_m, double curvature_per_m) {
  if (curvature_per_m == 0.0) return {way_m, left_m};
  const double angle = curvature_per_m * way_m, radius_m = 1.0 / curvature_per_m - left_m;
  return {radius_m * std::sin(angle), 1.0 / curvature_per_m - radius_m * std::cos(angle)};
}

inline std::vector<PointAt> lamps_beside_the_road(Random& random, int count,
                                                  double curvature_per_m = 0.0) {
  std::vector<PointAt> lights;
  for (int i = 0; i < count; ++i) {
    const double way_m = (count == 1 ? 80.0 : 30.0) + 25.0 * i + random.uniform(-5.0, 5.0);
    Eigen::Vector3d at_m;
    at_m << on_road_m(way_m, random.uniform(0.0, 1.0) < 0.5 ? -6.0 : 9.0, curvature_per_m),
        random.uniform(7.0, 9.0);
    lights.emplace_back([=](double) { return at_m; });
  }
  return lights;
}

/// A drive past lights, in exact terms: the ray of the camera is that of the point less its own
/// place, undone by heading, pose and turn.
struct Drive {
  double told_speed_mps = kSpeed_mps;
  double curvature_per_m = 0.0;
  std::size_t frames = kFrames;
  std::vector<PointAt> lights;
  TurnAt turn = [](std::size_t) { return Eigen::Vector3d::Zero().eval(); };

  Eigen::Vector2d place_m(double way_m) const { return on_road_m(way_m, 0.0, curvature_per_m); }

  TurnProblem seen(Random& random) const {
    const Eigen::Matrix3d pose = camera_from_road_rotation(0.004, -0.035, 0.0);
    TurnProblem problem;
    problem.camera_from_road = camera_from_road_rotation(0.0, -0.035, 0.0);
    problem.pose_std_rad = {0.002, 0.005, 0.003};
    problem.lights = lights.size();
    problem.frames = frames;
    for (std::size_t frame = 0; frame < frames; ++frame) {
      const double time_s = static_cast<double>(frame) / kRate_hz;
      const double way_m = kSpeed_mps * time_s, told_way_m = told_speed_mps * time_s;
      const Eigen::Vector3d turn_rad = turn(frame);
      const double angle_rad = turn_rad.norm();
      for (std::size_t light = 0; light < lights.size(); ++light) {
        Eigen::Vector3d off_m = lights[light](time_s);
        off_m.head<2>() -= place_m(way_m);
        off_m.z() -= kCameraHeight_m;
        Eigen::Vector3d ray =
            pose * Eigen::AngleAxisd(-curvature_per_m * way_m, Eigen::Vector3d::UnitZ()) * off_m;
        if (angle_rad > 0.0) ray = Eigen::AngleAxisd(-angle_rad, turn_rad / angle_rad) * ray;
        if (!(ray.z() > 1.0)) continue;
        const Eigen::Vector2d at = ray.hnormalized();
        if (std::abs(at.x()) > 0.6 || std::abs(at.y()) > 0.34) continue;
        const double sigma = kSigma_px / kFocal_px;
        problem.sightings.push_back(
            {frame, light, time_s, place_m(told_way_m), curvature_per_m * told_way_m,
             at + sigma * Eigen::Vector2d(random.normal(), random.normal()), sigma});
      }
    }
    return problem;
  }
};

}  // namespace vildar::drive
