#pragma once

#include <optional>

#include <Eigen/Core>

#include "types/site.h"

namespace vildar {

/// Direction in the road frame's axes: azimuth = atan2(y, x), positive to the left;
/// elevation = atan2(z, hypot(x, y)).
struct Bearing {
  double azimuth_rad = 0.0;
  double elevation_rad = 0.0;
};
Bearing bearing_of(const Eigen::Vector3d& ray_road);

/// Rotation that takes road axes to camera axes (x right, y down, z forward) for a camera turned by
/// yaw (left), pitch (up), roll (clockwise seen from behind), applied in that order, intrinsic.
Eigen::Matrix3d camera_from_road_rotation(double yaw_rad, double pitch_rad, double roll_rad);

/// Pinhole camera with lens distortion at a known place: the means of the site file.
class Camera {
 public:
  explicit Camera(const CameraSite& site);

  const Eigen::Vector3d& position_m() const { return position_m_; }
  const Eigen::Matrix3d& camera_from_road() const { return camera_from_road_; }
  /// Geometric mean of the two focal lengths.
  double focal_px() const;

  /// Pixel on which a road-frame point falls; nothing behind the camera or where the distortion
  /// model folds over. The pixel may lie outside the image.
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& point_road_m) const;

  /// Undistorted image coordinates (x/z, y/z in camera axes) of a pixel, and back.
  /// Nothing where the distortion model has no inverse there.
  std::optional<Eigen::Vector2d> normalized_from_pixel(const Eigen::Vector2d& pixel_px) const;
  std::optional<Eigen::Vector2d> pixel_from_normalized(const Eigen::Vector2d& normalized) const;

  /// Unit direction, in road axes, of the light that falls on a pixel.
  std::optional<Eigen::Vector3d> road_ray_from_pixel(const Eigen::Vector2d& pixel_px) const;

  /// Where the ray of a pixel meets the horizontal plane z = height_m in front of the camera.
  std::optional<Eigen::Vector2d> plane_point_m(const Eigen::Vector2d& pixel_px,
                                               double height_m) const;

 private:
  CameraSite site_;
  Eigen::Vector3d position_m_;
  Eigen::Matrix3d camera_from_road_;
  double distortion_radius_limit_;  ///< normalized radius up to which the model is one-to-one
};

}  // namespace vildar
