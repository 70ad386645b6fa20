#include "estimate/vehicle.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/clock.h"
#include "core/quantity.h"
#include "core/text.h"
#include "estimate/camera_view.h"
#include "estimate/clock_check.h"
#include "estimate/contradictions.h"
#include "estimate/delay_joint.h"
#include "estimate/delay_light.h"
#include "estimate/hypotheses.h"
#include "estimate/intensity_methods.h"
#include "estimate/joint_fit.h"
#include "estimate/lamp_size.h"
#include "estimate/lane_choice.h"
#include "estimate/light_checks.h"
#include "estimate/lit_surface.h"
#include "estimate/mixture.h"
#include "estimate/off_road.h"
#include "estimate/pass_delay.h"
#include "estimate/speed_budget.h"
#include "estimate/speed_gate.h"
#include "estimate/standing_light.h"
#include "estimate/trajectory.h"

namespace vildar {
namespace {

// Why a fitted speed is still not to be given, if so.
std::optional<Miss> gate_speed(const VehicleTrack& track, const Site& site,
                               const MotionState& state, const SpeedEstimate& speed) {
  constexpr double kClear = 3.0;  // sigmas
  if (track.ambiguous_identity) return Miss::ambiguous_identity;
  if (track.direction_contradicts) return Miss::direction_contradicts;
  if (std::abs(state.acceleration_mps2) > kHardestBraking_mps2) return Miss::bad_fit;
  if (!useful(speed) || may_be_a_post(track, site, speed)) return Miss::too_uncertain;
  if (too_fast(speed)) return Miss::not_on_road;
  const bool oncoming = track.direction == Direction::oncoming;
  if ((oncoming ? state.over_ground_mps : -state.over_ground_mps) < -kClear * speed.std_mps)
    return Miss::direction_contradicts;
  return std::nullopt;
}

// The camera as the fit found it turned.
Camera fitted_camera(CameraSite camera, const Trajectory& trajectory) {
  const PathVector& path = trajectory.fit.parameters;
  camera.yaw_rad.mean += path[kYaw];
  camera.pitch_rad.mean += path[kPitch];
  camera.roll_rad.mean += path[kRoll];
  for (double& focal_px : camera.focal_px) focal_px *= std::exp(path[kLogFocal]);
  return Camera(camera);
}

void add_states(std::span<const Trajectory> trajectories, std::vector<TrackRow>& rows) {
  for (TrackRow& row : rows) {
    if (row.time_s < trajectories.front().from_s || row.time_s > trajectories.front().to_s)
      continue;
    const MotionState state = mixed_state(trajectories, row.time_s);
    row.range_m = state.range_m;
    row.range_std_m = state.range_std_m;
    row.speed_mps = std::abs(state.over_ground_mps);
    row.speed_std_mps = state.speed_std_mps;
  }
}

// The speed that the program stands by, from trajectories and the method that gave them.
void report(const VehicleTrack& track, const Site& site, std::span<const Trajectory> trajectories,
            const SpeedEstimate& speed, VehicleResult& result) {
  const MotionState state = mixed_state(trajectories, speed.time_s);
  result.speed = speed;
  result.lane = sure_lane(trajectories);
  result.no_lane_probability = 0.0;
  for (const Trajectory& one : trajectories)
    if (one.lane.empty()) result.no_lane_probability += one.weight;
  result.withheld = gate_speed(track, site, state, speed);
  if (!result.withheld && in_no_lane(track, site, trajectories)) {
    result.withheld = Miss::not_on_road;
    result.warnings.push_back(beside_the_lanes(state.lateral_m));
  }
  if (!result.withheld && stands_all_the_time(track, site, trajectories.front(), speed)) {
    result.withheld = Miss::not_on_road;
    result.warnings.push_back(
        "stands all the time that it is seen: a lit sign, letters in the picture or a parked car");
  }
  if (result.withheld) return;
  result.range_ref_m = state.range_m;
  result.lateral_m = state.lateral_m;
  result.acceleration_mps2 = state.acceleration_mps2;
  result.closing_speed_mps = state.closing_mps;
  result.budget = speed_budget(trajectories.front(), speed.time_s);
  if (trajectories.size() > 1) {
    // What the vehicle is bears on the scale alone.
    const double relative = speed.std_mps / speed.speed_mps;
    SpeedBudget& budget = *result.budget;
    budget.scale = std::sqrt(std::max(0.0, relative * relative - budget.shape * budget.shape));
  }
  result.chi2_per_dof["camera"] = bearing_chi2_per_dof(trajectories.front());
}

SpeedEstimate speed_of(std::span<const Trajectory> trajectories) {
  const Trajectory& likeliest = trajectories.front();
  return mixed_speed(trajectories, best_time_s(likeliest, likeliest.from_s, likeliest.to_s));
}

struct Joined {
  std::vector<Trajectory> trajectories;
  double power_chi2_per_block = 0.0;
  std::int64_t samples = 0;
};

// Bearings with the delay of two photodiodes where there is one, else with the power of all. The
// delay tells the things that the vehicle may be apart; power does not.
Outcome<Joined> join(std::span<const Trajectory> camera_only, const Site& site,
                     std::span<const VehiclePower> power, const DelayFit* delay) {
  const auto photodiode = static_cast<std::size_t>(power.front().trace->photodiode);
  const double time_std_s = site.photodiodes.at(photodiode).time_offset_s.std;
  Joined joined;
  std::optional<Miss> miss;
  for (const Trajectory& one : camera_only) {
    auto outcome = delay ? fit_with_delay(one, *delay, time_std_s)
                         : fit_joint(one, site, power, one.from_s, one.to_s);
    if (const Miss* why = std::get_if<Miss>(&outcome)) {
      if (!miss) miss = *why;
      if (!delay && joined.trajectories.empty()) break;
      if (!delay) joined.trajectories.push_back(one);
      continue;
    }
    JointFit& fit = std::get<JointFit>(outcome);
    if (joined.samples == 0) {
      joined.samples = fit.samples;
      joined.power_chi2_per_block = fit.power_chi2_per_block;
    }
    joined.trajectories.push_back(std::move(fit.trajectory));
  }
  if (joined.trajectories.empty()) return *miss;
  if (delay) weigh(joined.trajectories);
  if (joined.trajectories.empty()) return Miss::not_converged;
  return joined;
}

// No speed is taken from the power of light.
void clear_light(Miss why, VehicleResult& result) {
  for (MethodResult& row : result.methods)
    if (row.method == Method::power_slope_photodiode || row.method == Method::ml_photodiode ||
        row.method == Method::curved_angle_photodiode)
      row.speed = why;
}

// So well that a pass that ends in time says more of them than a search in steps of half a second.
bool clocks_well_known(const Site& site) {
  constexpr double kKnown_s = 0.1;
  return std::ranges::all_of(site.photodiodes, [](const PhotodiodeSite& diode) {
    return diode.time_offset_s.std <= kKnown_s;
  });
}

// Adds the method `fused`, and where it holds makes it the one the program stands by; the
// trajectories are then those of both sensors. A pass that ends when the camera has the vehicle
// there bears the clocks out.
void fuse(const VehicleTrack& track, const Site& site, std::span<const VehiclePower> power,
          const DelayFit* delay, bool passes_in_time, std::vector<Trajectory>& trajectories,
          VehicleResult& result) {
  MethodResult method{Method::fused, Miss::unobservable, result.n_frames, ""};
  const auto fault =
      delay && !passes_in_time ? clock_fault(trajectories.front(), site, power) : std::nullopt;
  if (fault) {
    clear_light(Miss::sensors_contradict, result);
    for (MethodResult& row : result.methods)
      if (row.method == Method::delay_photodiodes) row.speed = Miss::sensors_contradict;
    method.speed = Miss::sensors_contradict;
    result.methods.push_back(method);
    result.warnings.push_back(*fault);
    return;
  }
  auto outcome = join(trajectories, site, power, delay);
  if (const Miss* miss = std::get_if<Miss>(&outcome)) {
    method.speed = *miss;
    result.methods.push_back(method);
    if (delay && *miss == Miss::sensors_contradict) {
      result.warnings.push_back(
          "the delay between the photodiodes and the camera's bearings contradict each other in "
          "speed or acceleration; check the camera's pose, the lamps, and the photodiodes' places "
          "and clock");
    } else if (*miss == Miss::bad_fit || *miss == Miss::sensors_contradict) {
      result.warnings.push_back("photodiode power does not agree with the camera (" +
                                std::string(name_of(*miss)) + "); the speed is the camera's alone");
    }
    return;
  }
  Joined& joined = std::get<Joined>(outcome);
  const SpeedEstimate speed = speed_of(joined.trajectories);
  method.samples += joined.samples;
  VehicleResult fused = result;
  report(track, site, joined.trajectories, speed, fused);
  if (fused.withheld) {
    method.speed = *fused.withheld;
    result.methods.push_back(method);
    return;
  }
  method.speed = speed;
  result = std::move(fused);
  result.method = Method::fused;
  result.used_photodiode = true;
  result.n_pd_samples = joined.samples;
  result.chi2_per_dof["photodiode"] = joined.power_chi2_per_block;
  result.methods.push_back(method);
  trajectories = std::move(joined.trajectories);
}

// Whether the light up to its peak between two clip times is of lamps that pulse.
bool pulses_by_its_peak(const PowerTrace& trace, const Site& site, double from_s, double to_s) {
  const double offset_s =
      site.photodiodes.at(static_cast<std::size_t>(trace.photodiode)).time_offset_s.mean;
  const auto sample_at = [&](double clip_s) {
    return std::ranges::lower_bound(trace.time_s, clip_s - offset_s) - trace.time_s.begin();
  };
  const auto first = trace.power_w.begin() + sample_at(from_s);
  const auto last = trace.power_w.begin() + sample_at(to_s);
  if (first == last) return false;
  const auto peak = std::max_element(first, last) - trace.power_w.begin();
  return pulses(trace, from_s - offset_s, trace.time_s[static_cast<std::size_t>(peak)]);
}

struct Delay {
  std::optional<DelayFit> fit;
  /// Why nothing is to be taken from this light: several_vehicles where one shines, too, that the
  /// camera does not see, outside_model where lamps pulse.
  std::optional<Miss> spoilt;
  bool warned = false;  ///< of that, by who offers the light
};

// What all vehicles in view shine does not explain the light of this one's time.
bool of_strangers(const VehiclePower& offered) {
  return offered.own_light && offered.own_light->time_s.empty();
}

// The vehicle passes the photodiodes after the camera has lost it, and may brake meanwhile: its
// speed is asked for in the time that the bearings tell of, but for the end, into which such a
// change is smeared.
struct Asked {
  double from_s = -INFINITY, to_s = INFINITY;
};

// By the light of its own pass, though others shine meanwhile.
Delay delay_of_pass(const OwnPass& own, const Site& site, const Asked& asked, MethodResult& row) {
  const SeenPass seen = best_seen(own.pass, site, own.traces);
  Delay delay;
  if (pulses(*seen.trace, seen.pass.from_s, seen.pass.peak_s)) {
    delay.spoilt = Miss::outside_model;
    return delay;
  }
  const auto outcome =
      pass_delay(seen, site, own.traces, lanes_towards(site.road), asked.from_s, asked.to_s);
  row = delay_row(outcome);
  if (const Miss* miss = std::get_if<Miss>(&outcome); miss && *miss == Miss::several_vehicles)
    delay.spoilt = *miss;
  if (const auto* fit = std::get_if<DelayFit>(&outcome); fit && useful(fit->speed))
    delay.fit = *fit;
  return delay;
}

// In how many lanes another vehicle may have made the light seem to change its speed; one where the
// camera saw it change as the light says.
std::size_t lanes_in_doubt(const DelayFit& fit, const Trajectory* trajectory,
                           const RoadSite& road) {
  constexpr double kClear_mps2 = 1.0, kAlike_mps2 = 1.0, kSigmas = 2.5;
  if (!trajectory) return lanes_towards(road);
  const MotionState seen = trajectory->at(fit.speed.time_s);
  const bool changes = std::abs(seen.acceleration_mps2) > kClear_mps2;
  const bool so = std::abs(seen.acceleration_mps2 - fit.acceleration_mps2) < kAlike_mps2 &&
                  std::abs(seen.over_ground_mps - fit.speed.speed_mps) <
                      kSigmas * std::hypot(seen.speed_std_mps, fit.speed.std_mps);
  return changes && so ? 1 : lanes_towards(road);
}

// By the traces of the time in which it is alone on them.
Delay delay_alone(const Site& site, std::span<const VehiclePower> power, const Asked& asked,
                  const Trajectory* trajectory, const VehicleResult& result, MethodResult& row) {
  constexpr double kBefore_s = 0.5, kPassing_s = 4.0;
  const double from_s = result.t_first_s - kBefore_s, to_s = result.t_last_s + kPassing_s;
  const auto clipped = [&](const PowerTrace& trace) {
    const double offset_s = site.photodiodes[trace.photodiode].time_offset_s.mean;
    return is_mostly_clipped(trace, from_s - offset_s, to_s - offset_s);
  };
  std::vector<const PowerTrace*> traces;
  bool shared = false;
  for (const VehiclePower& offered : power) {
    shared |= offered.shared;
    if (!offered.shared && !clipped(*offered.trace)) traces.push_back(offered.trace);
  }
  const auto outcome = delay_speed(site, traces, from_s, to_s, asked.from_s, asked.to_s);
  row = delay_row(outcome);
  if (traces.size() < power.size() && traces.size() < 2)
    row.speed = shared ? Miss::several_vehicles : Miss::saturated;
  Delay delay;
  const auto* fit = std::get_if<DelayFit>(&outcome);
  if (!fit) return delay;
  if (std::ranges::any_of(power, of_strangers))
    delay = {{}, Miss::several_vehicles, true};
  else if (std::ranges::any_of(traces, [&](const PowerTrace* trace) {
             return pulses_by_its_peak(*trace, site, from_s, to_s);
           }))
    delay.spoilt = Miss::outside_model;
  else if (of_several(*fit, lanes_in_doubt(*fit, trajectory, site.road), 0.0))
    delay.spoilt = Miss::several_vehicles;
  else if (useful(fit->speed))
    delay.fit = *fit;
  return delay;
}

// Adds the method `delay_photodiodes`.
Delay delay_of(const Site& site, std::span<const VehiclePower> power,
               const std::optional<OwnPass>& own_pass, const Trajectory* trajectory,
               VehicleResult& result) {
  constexpr double kSmear_s = 0.3;
  Asked asked;
  if (trajectory) asked = {trajectory->from_s, trajectory->to_s - kSmear_s};
  MethodResult row;
  Delay delay = own_pass ? delay_of_pass(*own_pass, site, asked, row)
                         : delay_alone(site, power, asked, trajectory, result, row);
  row.method = Method::delay_photodiodes;
  if (delay.spoilt) row.speed = *delay.spoilt;
  if (const auto* speed = std::get_if<SpeedEstimate>(&row.speed); speed && too_fast(*speed)) {
    result.warnings.push_back(warning_of_too_fast(row.method, *speed));
    row.speed = Miss::outside_model;
    delay.fit.reset();
  }
  result.methods.push_back(row);
  return delay;
}

// Of light that is spoilt no method's speed stands, and none contradicts the camera's.
void leave_to_camera(const Delay& delay, VehicleResult& result) {
  const Miss why = *delay.spoilt;
  clear_light(why, result);
  if (!result.withheld) result.methods.push_back({Method::fused, why, result.n_frames, ""});
  if (delay.warned) return;
  result.warnings.push_back(
      why == Miss::several_vehicles
          ? "the photodiodes' light does not move as that of one vehicle, another that the camera "
            "does not see may pass beside it: no speed is taken from it"
          : "the photodiodes' light jumps from sample to sample, as of lamps that pulse: no speed "
            "is taken from it");
}

// Where bearings give no speed for want of scale or of data, the delay's stands.
void stand_in(const DelayFit& delay, VehicleResult& result) {
  switch (*result.withheld) {
    case Miss::no_scale:
    case Miss::unobservable:
    case Miss::too_uncertain:
    case Miss::too_few_samples:
    case Miss::too_short: break;
    default: return;
  }
  result.withheld.reset();
  result.method = Method::delay_photodiodes;
  result.speed = delay.speed;
  result.used_camera = false;
  result.used_photodiode = true;
  result.n_pd_samples = delay.speed.samples_used;
  result.acceleration_mps2 = delay.acceleration_mps2;
  result.closing_speed_mps = delay.speed.speed_mps;
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
                                 std::span<const VehiclePower> power,
                                 const std::optional<OwnPass>& own_pass) {
  if (!site.camera) throw std::invalid_argument("estimate_vehicle: the site has no camera");
  const Camera camera(*site.camera);
  VehicleEstimate estimate;
  estimate.rows = bearing_rows(track, camera, site);
  VehicleResult& result = estimate.result;
  result = empty_result(track);

  std::vector<Trajectory> trajectories;
  // What passes before a camera that moves is told from what lies by the road no sooner.
  constexpr double kShortestMoving_s = 0.5;
  auto fitted = site.ego && result.t_last_s - result.t_first_s < kShortestMoving_s
                    ? Miss::too_short
                    : fit_trajectories(track, camera, site, result.warnings);
  if (const Miss* miss = std::get_if<Miss>(&fitted)) {
    result.withheld = *miss;
  } else {
    trajectories = std::get<std::vector<Trajectory>>(std::move(fitted));
    result.n_frames = trajectories.front().frames;
    report(track, site, trajectories, speed_of(trajectories), result);
  }
  MethodResult geometry{Method::geometry_camera, Miss::unobservable, result.n_frames, ""};
  if (result.withheld)
    geometry.speed = *result.withheld;
  else
    geometry.speed = result.speed;
  result.methods.push_back(geometry);

  const VehicleTrack sized =
      trajectories.empty() ? track : with_held_sizes(track, trajectories.front(), *site.camera);
  if (track.direction == Direction::oncoming && !site.ego) {
    const Trajectory* trajectory = trajectories.empty() ? nullptr : &trajectories.front();
    result.methods.push_back(camera_intensity_method(sized, site, trajectory));
    if (!power.empty()) {
      for (MethodResult& row : photodiode_methods(track, site, power, trajectory))
        result.methods.push_back(std::move(row));
      const Delay delay =
          power.size() > 1 ? delay_of(site, power, own_pass, trajectory, result) : Delay{};
      if (delay.spoilt)
        leave_to_camera(delay, result);
      else if (trajectory && !result.withheld)
        fuse(track, site, power, delay.fit ? &*delay.fit : nullptr,
             own_pass && clocks_well_known(site), trajectories, result);
      else if (delay.fit)
        stand_in(*delay.fit, result);
    }
  }
  if (result.withheld == Miss::no_scale)
    result.warnings.push_back(
        "speed is unobservable: no length fixes the scale; measure one of lamps.height_m (with "
        "camera.position_m), lamps.separation_m, road.radius_m, or the distance between two "
        "photodiodes along the road");
  if (!trajectories.empty() && !result.withheld && result.used_camera)
    check_sensors(trajectories, result);
  if (!trajectories.empty() && !result.withheld && result.used_camera) {
    estimate.rows = bearing_rows(sized, fitted_camera(*site.camera, trajectories.front()), site);
    add_states(trajectories, estimate.rows);
    if (const std::string doubt = doubt_text(trajectories, result.speed.time_s); !doubt.empty())
      result.warnings.push_back("what the vehicle is cannot be told for sure (" + doubt +
                                "); its interval covers all of them");
    estimate.trajectories = std::move(trajectories);
  }
  if (const auto wide_m = width_of_surface_m(estimate.rows, *site.camera))
    withhold(estimate, Miss::not_on_road, {Method::geometry_camera, Method::fused},
             "its light is " + fixed_text(*wide_m, 1) +
                 " m wide where it seems to be, and does not clip: a lit window or sign");
  return estimate;
}

void withhold(VehicleEstimate& estimate, Miss miss, std::initializer_list<Method> methods,
              const std::string& warning) {
  const VehicleResult& was = estimate.result;
  VehicleResult result;
  result.track_id = was.track_id;
  result.direction = was.direction;
  result.t_first_s = was.t_first_s;
  result.t_last_s = was.t_last_s;
  result.n_frames = was.n_frames;
  result.used_camera = true;
  result.withheld = miss;
  result.methods = was.methods;
  for (MethodResult& method : result.methods)
    if (std::ranges::find(methods, method.method) != methods.end()) method.speed = miss;
  result.warnings = was.warnings;
  result.warnings.push_back(warning);
  estimate.result = std::move(result);
  estimate.trajectories.clear();
  for (TrackRow& row : estimate.rows)
    row.range_m = row.range_std_m = row.speed_mps = row.speed_std_mps = std::nullopt;
}

}  // namespace vildar
