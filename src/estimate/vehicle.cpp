#include "estimate/vehicle.h"

#include <stdexcept>

#include "core/clock.h"
#include "estimate/camera_view.h"

namespace vildar {

VehicleEstimate estimate_vehicle(const VehicleTrack& track, const Site& site,
                                 std::span<const VehiclePower> /*power*/) {
  if (!site.camera) throw std::invalid_argument("estimate_vehicle: the site has no camera");
  const Camera camera(*site.camera);
  VehicleEstimate estimate;
  estimate.rows = bearing_rows(track, camera, site);
  VehicleResult& result = estimate.result;
  result.track_id = track.id;
  result.direction = track.direction;
  result.used_camera = true;
  result.n_frames = static_cast<int>(track.sightings.size());
  if (!track.sightings.empty()) {
    result.t_first_s = seconds_of(track.sightings.front().time);
    result.t_last_s = seconds_of(track.sightings.back().time);
  }
  result.withheld = Miss::unobservable;
  return estimate;
}

VehicleResult estimate_pass(const PowerPass& pass, int pass_number, const Site& site,
                            std::span<const PowerTrace> traces) {
  if (traces.empty()) throw std::invalid_argument("estimate_pass: no photodiode trace given");
  const double offset_s =
      site.photodiodes.at(static_cast<std::size_t>(traces.front().photodiode)).time_offset_s.mean;
  VehicleResult result;
  result.track_id = pass_number;
  result.t_first_s = pass.from_s + offset_s;
  result.t_last_s = pass.to_s + offset_s;
  result.used_photodiode = true;
  result.withheld = Miss::unobservable;
  return result;
}

}  // namespace vildar
