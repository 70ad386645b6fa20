#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

namespace vildar {

/// A sighting of a light from a camera that has moved since the light's reference time.
struct PassedView {
  Eigen::Matrix3d turned = Eigen::Matrix3d::Identity();  ///< camera axes, from those at that time
  Eigen::Vector3d moved_m = Eigen::Vector3d::Zero();     ///< way back, in camera axes
  Eigen::Vector2d at = Eigen::Vector2d::Zero();          ///< undistorted x/z, y/z
};

/// Where a light stands: x/z and y/z from the camera at the reference time, and 1/z (1/m).
using LightPlace = Eigen::Vector3d;

/// Before anything is seen, one sigma of 1/z.
inline constexpr double kInverseDistance_per_m = 0.2;

struct ExpectedView {
  Eigen::Vector2d at;
  Eigen::Matrix<double, 2, 3> by_place;
};
/// Where a light is to be seen by a camera in its mean pose; nothing beside or behind the camera.
std::optional<ExpectedView> expected_view(const PassedView& view, const LightPlace& place);

/// The place that explains the sightings of one light best, each known to `sigma`; `reference` is
/// the one at its reference time.
LightPlace first_place(std::span<const PassedView> views, const Eigen::Vector2d& reference,
                       double sigma);

}  // namespace vildar
