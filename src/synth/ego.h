#pragma once

#include <optional>

#include <Eigen/Core>

#include "synth/scenario.h"

namespace vildar {

/// Where the sensors' own vehicle is, in the road frame of t = 0 (which a fixed sensor keeps).
struct EgoPose {
  Eigen::Vector2d place_m = Eigen::Vector2d::Zero();
  double heading_rad = 0.0;  ///< anticlockwise from +x

  /// A ground point of the frame of t = 0 as it stands in the frame that moves with the sensors.
  Eigen::Vector2d seen_m(const Eigen::Vector2d& point_m) const;
  /// The way back.
  Eigen::Vector2d still_m(const Eigen::Vector2d& seen_m) const;
  Eigen::Vector2d turned(const Eigen::Vector2d& direction) const;
};

/// Speed and yaw rate are linear between the samples of a trace and held beyond its ends. Where no
/// yaw rate says otherwise, the vehicle follows the road's line y = 0.
EgoPose ego_pose(const Site& site, double time_s);

/// The shake of the camera. A shaken camera sees a point where a steady one would see the point
/// that `steady_m` gives.
class CameraShake {
 public:
  explicit CameraShake(const Scenario& scenario);

  /// Yaw and pitch beyond those of the site, rad.
  Eigen::Vector2d turn_rad(double time_s) const;
  Eigen::Vector3d steady_m(const Eigen::Vector3d& point_m, double time_s) const;
  bool still() const { return scene_.yaw_std_rad == 0.0 && scene_.pitch_std_rad == 0.0; }

 private:
  static constexpr int kSines = 5;
  ShakeScene scene_;
  Eigen::Vector3d camera_m_ = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, kSines, 2> phase_rad_;
};

}  // namespace vildar
