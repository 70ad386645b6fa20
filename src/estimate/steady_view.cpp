#include "estimate/steady_view.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "optics/camera.h"

namespace vildar {
namespace {

// What the uncertainty of a turn adds to an image place, as standard deviations in focal lengths.
Eigen::Vector2d turn_std(const Eigen::Vector2d& place, const CameraTurn& turn) {
  const Eigen::Matrix<double, 2, 3> effect = turn_effect(place);
  return (effect * turn.covariance * effect.transpose()).diagonal().cwiseSqrt();
}

void steady(LampSighting& lamp, const CameraTurn& turn, const Camera& camera) {
  const auto seen = camera.normalized_from_pixel(lamp.centre_px);
  if (!seen || turn.rotation_rad.isZero()) return;
  const Eigen::Vector2d at_rest = rotated(*seen, turn.rotation_rad);
  const auto pixel_px = camera.pixel_from_normalized(at_rest);
  if (!pixel_px) return;
  lamp.centre_px = *pixel_px;
  const Eigen::Vector2d added_px = camera.focal_px() * turn_std(at_rest, turn);
  lamp.centre_sigma_px = (lamp.centre_sigma_px.cwiseAbs2() + added_px.cwiseAbs2()).cwiseSqrt();
}

}  // namespace

std::optional<SteadyView> steady_view(const VehicleTrack& track,
                                      std::span<const std::optional<CameraTurn>> turns,
                                      const Site& site) {
  if (!site.camera ||
      std::ranges::none_of(turns, [](const auto& turn) { return turn.has_value(); }))
    return std::nullopt;
  const Camera camera(*site.camera);
  SteadyView view{track, site};
  Eigen::Vector3d mean_std_rad = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < turns.size(); ++i) {
    if (!turns[i]) continue;
    mean_std_rad = mean_std_rad.cwiseMax(turns[i]->mean_std_rad);
    VehicleSighting& sighting = view.track.sightings[i];
    for (std::optional<LampSighting>* lamp : {&sighting.left, &sighting.right})
      if (*lamp) steady(**lamp, *turns[i], camera);
  }
  // About the axes right, down and forward.
  CameraSite& pose = *view.site.camera;
  const std::array<Uncertain*, 3> pose_rad{&pose.pitch_rad, &pose.yaw_rad, &pose.roll_rad};
  for (std::size_t axis = 0; axis < 3; ++axis)
    pose_rad[axis]->std =
        std::hypot(pose_rad[axis]->std, mean_std_rad[static_cast<Eigen::Index>(axis)]);
  return view;
}

}  // namespace vildar
