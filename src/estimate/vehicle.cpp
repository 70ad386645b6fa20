#include "estimate/vehicle.h"

#include <cmath>
#include <stdexcept>

#include "core/clock.h"
#include "estimate/camera_view.h"
#include "estimate/trajectory.h"

namespace vildar {
namespace {

// Why a fitted speed is still not to be given, if so.
std::optional<Miss> gate_speed(const VehicleTrack& track, const MotionState& state,
                               const SpeedEstimate& speed) {
  constexpr double kFastest_mps = 100.0;
  constexpr double kClear = 3.0;  // sigmas
  constexpr double kUseful = 0.25, kUseful_mps = 3.0;
  if (track.ambiguous_identity) return Miss::ambiguous_identity;
  if (track.direction_contradicts) return Miss::direction_contradicts;
  if (speed.std_mps > kUseful * speed.speed_mps && speed.std_mps > kUseful_mps)
    return Miss::too_uncertain;
  if (speed.speed_mps - kClear * speed.std_mps > kFastest_mps) return Miss::not_on_road;
  const bool oncoming = track.direction == Direction::oncoming;
  if ((oncoming ? state.over_ground_mps : -state.over_ground_mps) < -kClear * speed.std_mps)
    return Miss::direction_contradicts;
  return std::nullopt;
}

void add_states(const Trajectory& trajectory, std::vector<TrackRow>& rows) {
  for (TrackRow& row : rows) {
    const MotionState state = trajectory.at(row.time_s);
    row.range_m = state.range_m;
    row.range_std_m = state.range_std_m;
    row.speed_mps = std::abs(state.over_ground_mps);
    row.speed_std_mps = state.speed_std_mps;
  }
}

// The speed that the program stands by, from a trajectory and the method that gave it.
void report(const VehicleTrack& track, const Trajectory& trajectory, const SpeedEstimate& speed,
            VehicleResult& result) {
  const MotionState state = trajectory.at(speed.time_s);
  result.speed = speed;
  result.lane = trajectory.lane;
  result.withheld = gate_speed(track, state, speed);
  if (result.withheld) return;
  result.range_ref_m = state.range_m;
  result.lateral_m = state.lateral_m;
  result.acceleration_mps2 = state.acceleration_mps2;
  result.closing_speed_mps = state.closing_mps;
}

VehicleResult empty_result(const VehicleTrack& track) {
  VehicleResult result;
  result.track_id = track.id;
  result.direction = track.direction;
  result.used_camera = true;
  result.n_frames = static_cast<int>(track.sightings.size());
  if (!track.sightings.empty()) {
    result.t_first_s = seconds_of(track.sightings.front().time);
    result.t_last_s = seconds_of(track.sightings.back().time);
  }
  return result;
}

}  // namespace

VehicleEstimate estimate_vehicle(const VehicleTrack& track, const Site& site,
                                 std::span<const VehiclePower> /*power*/) {
  if (!site.camera) throw std::invalid_argument("estimate_vehicle: the site has no camera");
  const Camera camera(*site.camera);
  VehicleEstimate estimate;
  estimate.rows = bearing_rows(track, camera, site);
  VehicleResult& result = estimate.result;
  result = empty_result(track);

  const auto fitted = fit_trajectory(track, camera, site, result.warnings);
  MethodResult geometry{Method::geometry_camera, Miss::unobservable, result.n_frames, ""};
  if (const Miss* miss = std::get_if<Miss>(&fitted)) {
    geometry.speed = *miss;
    result.withheld = *miss;
  } else {
    const Trajectory& trajectory = std::get<Trajectory>(fitted);
    const double time_s = best_time_s(trajectory, result.t_first_s, result.t_last_s);
    const SpeedEstimate speed =
        speed_estimate(trajectory.at(time_s), time_s, trajectory.ego.moving(), trajectory.frames);
    report(track, trajectory, speed, result);
    if (result.withheld)
      geometry.speed = *result.withheld;
    else
      geometry.speed = speed;
    if (!result.withheld) add_states(trajectory, estimate.rows);
  }
  result.methods.push_back(geometry);
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
