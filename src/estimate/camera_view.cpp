#include "estimate/camera_view.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/clock.h"

namespace vildar {
namespace {

// Fewer frames than this cannot carry the estimate on their own.
constexpr int kEnoughPairs = 5;
constexpr double kEnoughPairShare = 0.5;
// A centroid is never trusted beyond this, whatever its formal sigma.
constexpr double kLeastSigma_px = 0.01;

std::optional<LampObservation> observe(const LampSighting& lamp, std::size_t sighting,
                                       CameraTime frame_time, double side, const Camera& camera,
                                       const CameraSite& site) {
  const auto normalized = camera.normalized_from_pixel(lamp.centre_px);
  if (!normalized || has(lamp.defects, Defect::cut_by_edge)) return std::nullopt;
  LampObservation seen;
  seen.sighting = sighting;
  seen.time_s = seconds_of(row_time(frame_time, site.rolling_shutter_s, lamp.row_fraction));
  seen.normalized = *normalized;
  for (int axis = 0; axis < 2; ++axis)
    seen.sigma[axis] = std::max(lamp.centre_sigma_px[axis], kLeastSigma_px) / site.focal_px[axis];
  seen.side = side;
  return seen;
}

std::optional<Eigen::Vector2d> bearing_of_lamp(const std::optional<LampSighting>& lamp,
                                               const Camera& camera) {
  if (!lamp) return std::nullopt;
  const auto ray = camera.road_ray_from_pixel(lamp->centre_px);
  if (!ray) return std::nullopt;
  const Bearing bearing = bearing_of(*ray);
  return Eigen::Vector2d(bearing.azimuth_rad, bearing.elevation_rad);
}

// The middle of the pair in space: half way between the lamps on their common height. Which height
// does not matter, as all scale about the camera; without a plane below, half way in the image.
std::optional<Eigen::Vector2d> bearing_of_middle(const VehicleSighting& sighting,
                                                 const Camera& camera, double lamp_height_m) {
  const Eigen::Vector2d& left_px = sighting.left->centre_px;
  const Eigen::Vector2d& right_px = sighting.right->centre_px;
  const auto left_m = camera.plane_point_m(left_px, lamp_height_m);
  const auto right_m = camera.plane_point_m(right_px, lamp_height_m);
  Eigen::Vector3d ray;
  if (left_m && right_m) {
    ray << 0.5 * (*left_m + *right_m), lamp_height_m;
    ray -= camera.position_m();
  } else {
    const auto left = camera.normalized_from_pixel(left_px);
    const auto right = camera.normalized_from_pixel(right_px);
    if (!left || !right) return std::nullopt;
    const Eigen::Vector2d middle = 0.5 * (*left + *right);
    ray = camera.camera_from_road().transpose() * Eigen::Vector3d(middle.x(), middle.y(), 1.0);
  }
  const Bearing bearing = bearing_of(ray);
  return Eigen::Vector2d(bearing.azimuth_rad, bearing.elevation_rad);
}

BearingOf best_shown(const VehicleTrack& track) {
  int both = 0, in_one = 0, left = 0, right = 0;
  for (const VehicleSighting& sighting : track.sightings) {
    in_one += sighting.both_in_one;
    if (sighting.both_in_one) continue;
    both += sighting.left && sighting.right;
    left += sighting.left.has_value();
    right += sighting.right.has_value();
  }
  if (!track.single_lamp && both >= kEnoughPairs)
    return both >= kEnoughPairShare * static_cast<double>(track.sightings.size())
               ? BearingOf::pair
               : BearingOf::each_lamp;
  if (both + in_one >= std::max(left, right)) return BearingOf::middle;
  return left >= right ? BearingOf::left_lamp : BearingOf::right_lamp;
}

}  // namespace

std::vector<LampObservation> frame_lamps(const VehicleSighting& sighting, std::size_t index,
                                         BearingOf of, const Camera& camera,
                                         const CameraSite& site) {
  std::vector<LampObservation> lamps;
  const auto add = [&](const std::optional<LampSighting>& lamp, double side) {
    const auto seen =
        lamp ? observe(*lamp, index, sighting.time, side, camera, site) : std::nullopt;
    if (seen) lamps.push_back(*seen);
  };
  const bool both = sighting.left && sighting.right;
  if (of == BearingOf::pair && !both) return lamps;
  if (sighting.both_in_one) {
    add(sighting.left ? sighting.left : sighting.right, 0.0);
  } else if (of == BearingOf::pair || of == BearingOf::each_lamp) {
    add(sighting.left, 0.5);
    add(sighting.right, -0.5);
  } else if (of == BearingOf::left_lamp) {
    add(sighting.left, 0.0);
  } else if (of == BearingOf::right_lamp) {
    add(sighting.right, 0.0);
  } else if (both) {
    const auto left = observe(*sighting.left, index, sighting.time, 0.0, camera, site);
    const auto right = observe(*sighting.right, index, sighting.time, 0.0, camera, site);
    if (!left || !right) return lamps;
    LampObservation middle = *left;
    middle.time_s = 0.5 * (left->time_s + right->time_s);
    middle.normalized = 0.5 * (left->normalized + right->normalized);
    middle.sigma = 0.5 * (left->sigma.cwiseAbs2() + right->sigma.cwiseAbs2()).cwiseSqrt();
    lamps.push_back(middle);
  }
  return lamps;
}

CameraView camera_view(const VehicleTrack& track, const Camera& camera, const CameraSite& site) {
  CameraView view;
  view.of = best_shown(track);
  for (std::size_t i = 0; i < track.sightings.size(); ++i) {
    const auto lamps = frame_lamps(track.sightings[i], i, view.of, camera, site);
    view.lamps.insert(view.lamps.end(), lamps.begin(), lamps.end());
    view.frames += !lamps.empty();
  }
  return view;
}

std::vector<TrackRow> bearing_rows(const VehicleTrack& track, const Camera& camera,
                                   const Site& site) {
  const double lamp_height_m = site.lamps.height_m ? site.lamps.height_m->mean : 0.0;
  std::vector<TrackRow> rows;
  rows.reserve(track.sightings.size());
  for (const VehicleSighting& sighting : track.sightings) {
    TrackRow row;
    row.track_id = track.id;
    row.sighting = sighting;
    row.time_s = seconds_of(sighting.time);
    double variance = 0.0;
    bool bound = false;
    for (const auto& lamp : {sighting.left, sighting.right}) {
      if (!lamp) continue;
      const LampLight light = light_of(*lamp);
      row.intensity += light.flux;
      variance += light.flux_sigma * light.flux_sigma;
      bound = bound || is_bound(*lamp);
    }
    row.intensity_std = bound ? row.intensity : std::sqrt(variance);
    row.bearing_left_rad = bearing_of_lamp(sighting.left, camera);
    row.bearing_right_rad = bearing_of_lamp(sighting.right, camera);
    if (sighting.left && sighting.right)
      row.bearing_rad = bearing_of_middle(sighting, camera, lamp_height_m);
    else if (track.single_lamp)
      row.bearing_rad = sighting.left ? row.bearing_left_rad : row.bearing_right_rad;
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace vildar
