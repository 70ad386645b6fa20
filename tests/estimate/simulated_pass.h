#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"
#include "optics/camera.h"
#include "types/site.h"
#include "types/vehicle_track.h"

namespace vildar::simulated {

/// From here on the acceleration is another, by so much.
struct AccelerationChange {
  double at_s = 0.0, mps2 = 0.0;

  double since_s(double t_s) const { return std::max(0.0, t_s - at_s); }
};

/// A way across the road, by half a period of a cosine.
struct LaneChange {
  double at_s = 0.0, lasts_s = 0.0, to_left_m = 0.0;

  double phase(double t_s) const {
    return lasts_s > 0.0 ? std::clamp((t_s - at_s) / lasts_s, 0.0, 1.0) : 0.0;
  }
  double left_m(double t_s) const {
    return 0.5 * to_left_m * (1.0 - std::cos(std::numbers::pi * phase(t_s)));
  }
  double left_mps(double t_s) const {
    return lasts_s > 0.0 ? 0.5 * to_left_m * std::numbers::pi / lasts_s *
                               std::sin(std::numbers::pi * phase(t_s))
                         : 0.0;
  }
};

/// A driver's way to and fro about the lane's middle.
struct Weave {
  double left_m = 0.0, period_s = 8.0, phase_rad = 0.0;

  double left_at_m(double t_s) const {
    return left_m * std::sin(2.0 * std::numbers::pi * t_s / period_s + phase_rad);
  }
};

/// A vehicle with constant acceleration on a straight or curved road, in closed form.
struct Vehicle {
  double speed_mps = 20.0;         ///< along the path at t = 0, positive toward the sensor
  double acceleration_mps2 = 0.0;  ///< of the same
  double along_m = 60.0;           ///< path length from x = 0 at t = 0
  double lateral_m = -4.0;
  double height_m = 0.68;
  double separation_m = 1.25;
  std::vector<AccelerationChange> changes{};
  LaneChange lane_change{};  ///< on a bend at the same speed; in view on the bend alone, from t = 0
  Weave weave{};             ///< too slow to turn the vehicle

  double along_at_m(double t_s) const {
    double to_go_m = along_m - speed_mps * t_s - 0.5 * acceleration_mps2 * t_s * t_s;
    for (const AccelerationChange& change : changes)
      to_go_m -= 0.5 * change.mps2 * change.since_s(t_s) * change.since_s(t_s);
    return to_go_m;
  }
  double speed_at_mps(double t_s) const {
    double at_mps = speed_mps + acceleration_mps2 * t_s;
    for (const AccelerationChange& change : changes) at_mps += change.mps2 * change.since_s(t_s);
    return at_mps;
  }
};

struct Lamps {
  Eigen::Vector3d left_m, right_m, middle_m;
};

/// Angle of the arc at which a vehicle stands that crosses concentric lanes: each metre of its way
/// is a metre of its path.
inline double beta_at_rad(const Vehicle& vehicle, double radius_m, double sign, double t_s) {
  constexpr int kPieces = 400;
  const double piece_s = t_s / kPieces;
  double beta_rad = vehicle.along_m / radius_m;
  for (int i = 0; i < kPieces; ++i) {
    const double at_s = (i + 0.5) * piece_s;
    const double left_mps = vehicle.lane_change.left_mps(at_s), v_mps = vehicle.speed_at_mps(at_s);
    beta_rad -= piece_s * std::sqrt(v_mps * v_mps - left_mps * left_mps) /
                (radius_m - sign * vehicle.lane_change.left_m(at_s));
  }
  return beta_rad;
}

/// The lamps in the road frame. On a curve: straight to `straight_m`, then an arc concentric with
/// the road's; written out from the circle's centre, apart from the code under test.
inline Lamps lamps_at(const Vehicle& vehicle, const RoadSite& road, double t_s) {
  const double s_m = vehicle.along_at_m(t_s);
  const double aside_m = vehicle.weave.left_at_m(t_s) + vehicle.lane_change.left_m(t_s);
  Eigen::Vector2d middle(s_m, vehicle.lateral_m + aside_m), left(0.0, 1.0);
  if (const double left_mps = vehicle.lane_change.left_mps(t_s); left_mps != 0.0)
    left = Eigen::Vector2d(left_mps / vehicle.speed_at_mps(t_s), 1.0).normalized();
  if (road.kind == RoadKind::curved && s_m > road.straight_m.mean) {
    const double sign = road.turn == Turn::left ? 1.0 : -1.0;
    const Eigen::Vector2d centre(road.straight_m.mean, sign * road.radius_m->mean);
    const double radius_m = std::abs(centre.y() - vehicle.lateral_m);
    const bool crosses = vehicle.lane_change.lasts_s > 0.0;
    const double beta_rad = crosses ? beta_at_rad(vehicle, radius_m, sign, t_s)
                                    : (s_m - road.straight_m.mean) / radius_m;
    const Eigen::Vector2d outward(std::sin(beta_rad), -sign * std::cos(beta_rad));
    const double turns = vehicle.lane_change.left_mps(t_s) / vehicle.speed_at_mps(t_s);
    const Eigen::Vector2d away(std::cos(beta_rad), sign * std::sin(beta_rad));
    middle = centre + (radius_m - sign * aside_m) * outward;
    left = (turns * away - sign * outward).normalized();
  }
  const auto lift = [&](const Eigen::Vector2d& p) {
    return Eigen::Vector3d(p.x(), p.y(), vehicle.height_m);
  };
  return {lift(middle + 0.5 * vehicle.separation_m * left),
          lift(middle - 0.5 * vehicle.separation_m * left), lift(middle)};
}

struct View {
  double from_s = 0.0, to_s = 2.5;
  double frame_rate_hz = 30.0;
  double sigma_px = 0.2;
  bool single_lamp = false;
  double ego_mps = 0.0;            ///< the camera drives along +x
  double ego_yaw_rad_per_s = 0.0;  ///< or on a circle that leaves +x, with no acceleration
  double ego_acceleration_mps2 = 0.0;
  /// Or as this says: x, y and heading by time, at y = 0 along +x where it does not swerve.
  const std::function<Eigen::Vector3d(double)>* ego_pose = nullptr;
  double shake_px = 0.0;  ///< per axis, common to all lamps of a frame
  double flux_at_1m = 1000.0, path_loss_exponent = 2.0, flux_relative_sigma = 0.0;
};

/// What a camera reports of the pass: centroids with Gaussian noise of the stated sigma.
inline VehicleTrack track_of(const Vehicle& vehicle, const Site& site, const View& view,
                             Random& random) {
  const Camera camera(*site.camera);
  VehicleTrack track;
  track.id = 1;
  track.single_lamp = view.single_lamp;
  const double height_px = site.camera->height_px;
  Eigen::Vector2d shaken_px = Eigen::Vector2d::Zero();
  const auto sight = [&](const Eigen::Vector3d& point_m) -> std::optional<LampSighting> {
    const auto pixel = camera.project(point_m);
    if (!pixel || pixel->x() < 0 || pixel->x() >= site.camera->width_px || pixel->y() < 0 ||
        pixel->y() >= height_px)
      return std::nullopt;
    LampSighting lamp;
    lamp.centre_px =
        *pixel + shaken_px + view.sigma_px * Eigen::Vector2d(random.normal(), random.normal());
    lamp.centre_sigma_px.setConstant(view.sigma_px);
    const double distance_m = (point_m - camera.position_m()).norm();
    lamp.flux = view.flux_at_1m * std::pow(distance_m, -view.path_loss_exponent) *
                (1.0 + view.flux_relative_sigma * random.normal());
    lamp.flux_sigma = lamp.flux * view.flux_relative_sigma;
    lamp.row_fraction = (pixel->y() + 0.5) / height_px - 0.5;
    return lamp;
  };
  const int frames =
      static_cast<int>(std::floor((view.to_s - view.from_s) * view.frame_rate_hz)) + 1;
  for (int i = 0; i < frames; ++i) {
    const double t_s = view.from_s + i / view.frame_rate_hz;
    shaken_px = view.shake_px * Eigen::Vector2d(random.normal(), random.normal());
    // The row, and so the instant, at which a lamp is read follows from where it is seen.
    const auto sight_in_time = [&](auto choose) {
      double at_s = t_s;
      for (int step = 0; step < 3 && site.camera->rolling_shutter_s > 0.0; ++step) {
        const auto pixel = camera.project(choose(lamps_at(vehicle, site.road, at_s)));
        if (pixel)
          at_s = t_s + ((pixel->y() + 0.5) / height_px - 0.5) * site.camera->rolling_shutter_s;
      }
      Eigen::Vector3d point_m = choose(lamps_at(vehicle, site.road, at_s));
      point_m.x() -= at_s * (view.ego_mps + 0.5 * at_s * view.ego_acceleration_mps2);
      if (view.ego_yaw_rad_per_s != 0.0) {
        // The circle's chord instead of the straight way, seen from a vehicle that has turned.
        const double turn_rad = view.ego_yaw_rad_per_s * at_s;
        const double radius_m = view.ego_mps / view.ego_yaw_rad_per_s;
        const double x_m = point_m.x() + view.ego_mps * at_s - radius_m * std::sin(turn_rad);
        const double y_m = point_m.y() - radius_m * (1.0 - std::cos(turn_rad));
        point_m.x() = std::cos(turn_rad) * x_m + std::sin(turn_rad) * y_m;
        point_m.y() = std::cos(turn_rad) * y_m - std::sin(turn_rad) * x_m;
      }
      if (view.ego_pose) {
        const Eigen::Vector3d pose = (*view.ego_pose)(at_s);
        const double x_m = point_m.x() - pose.x(), y_m = point_m.y() - pose.y();
        point_m.x() = std::cos(pose.z()) * x_m + std::sin(pose.z()) * y_m;
        point_m.y() = std::cos(pose.z()) * y_m - std::sin(pose.z()) * x_m;
      }
      return sight(point_m);
    };
    VehicleSighting sighting;
    sighting.frame = i;
    sighting.time = time_from_seconds<CameraTime>(t_s);
    if (view.single_lamp) {
      sighting.left = sight_in_time([](const Lamps& lamps) { return lamps.middle_m; });
      if (!sighting.left) continue;
    } else {
      sighting.left = sight_in_time([](const Lamps& lamps) { return lamps.left_m; });
      sighting.right = sight_in_time([](const Lamps& lamps) { return lamps.right_m; });
      if (!sighting.left && !sighting.right) continue;
    }
    track.sightings.push_back(sighting);
  }
  return track;
}

/// A straight road with one oncoming lane, seen from a mast.
inline Site mast_site(double camera_height_m) {
  Site site;
  CameraSite camera;
  camera.width_px = 1920;
  camera.height_px = 1080;
  camera.focal_px = {1400.0, 1400.0};
  camera.principal_px = {959.5, 539.5};
  camera.position_m = {Uncertain{0.0, 0.0}, Uncertain{0.0, 0.0}, Uncertain{camera_height_m, 0.0}};
  camera.pitch_rad.mean = radians_from_degrees(-4.0);
  site.camera = camera;
  site.road.lanes = {{"near", {-4.0, 0.3}, 3.5, Direction::oncoming}};
  site.lamps.height_m = Uncertain{0.65, 0.1};
  site.lamps.separation_m = Uncertain{1.2, 0.15};
  return site;
}

/// The right lamps of two vehicles, `one` seen to the left of the other, taken for one vehicle's
/// two.
inline VehicleTrack right_lamps_of(VehicleTrack one, const VehicleTrack& other) {
  EXPECT_EQ(one.sightings.size(), other.sightings.size());
  for (std::size_t k = 0; k < one.sightings.size(); ++k) {
    one.sightings[k].left = one.sightings[k].right;
    one.sightings[k].right = other.sightings[k].right;
  }
  return one;
}

}  // namespace vildar::simulated
