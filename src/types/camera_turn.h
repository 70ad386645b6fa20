#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace vildar {

/// How a camera was turned in one frame from its mean pose on its stand or in its vehicle.
struct CameraTurn {
  /// About the camera's axes (right, down, forward): what lies at x at its mean pose is seen at
  /// x - rotation x x, to first order.
  Eigen::Vector3d rotation_rad = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  /// Of the mean pose itself, about the same axes: an error that all frames share.
  Eigen::Vector3d mean_std_rad = Eigen::Vector3d::Zero();
};

/// Movement of an undistorted image place (x/z, y/z) per radian of rotation_rad.
inline Eigen::Matrix<double, 2, 3> turn_effect(const Eigen::Vector2d& place) {
  const double x = place.x(), y = place.y();
  Eigen::Matrix<double, 2, 3> effect;
  effect << x * y, -(1.0 + x * x), y, 1.0 + y * y, -x * y, -x;
  return effect;
}

/// Where what is seen at a place (x/z, y/z) would be seen by a camera turned back by that rotation.
inline Eigen::Vector2d rotated(const Eigen::Vector2d& place, const Eigen::Vector3d& rotation_rad) {
  const double angle_rad = rotation_rad.norm();
  if (!(angle_rad > 0.0)) return place;
  const Eigen::Vector3d ray =
      Eigen::AngleAxisd(angle_rad, rotation_rad / angle_rad) * place.homogeneous();
  return ray.hnormalized();
}

}  // namespace vildar
