#include "estimate/intensity_methods.h"

#include <cmath>
#include <optional>

#include "core/clock.h"
#include "estimate/light_checks.h"
#include "estimate/ml_speed.h"
#include "estimate/photodiode_speed.h"
#include "optics/road.h"

namespace vildar {
namespace {

constexpr std::size_t kFewestFrames = 5;
constexpr double kShortest_s = 0.2;

// Place of the vehicle from its bearings, else from the one lane it can be in.
std::optional<VehiclePlace> known_place(const Site& site, Direction direction,
                                        const Trajectory* trajectory) {
  if (trajectory) return place_of(*trajectory);
  const LaneSite* only = nullptr;
  for (const LaneSite& lane : site.road.lanes) {
    if (lane.direction != direction) continue;
    if (only) return std::nullopt;
    only = &lane;
  }
  return only ? place_of(*only, site) : std::nullopt;
}

struct Frames {
  PowerSeries series;
  int clipped = 0;
};

Frames usable_frames(const VehicleTrack& track) {
  Frames frames;
  for (const VehicleSighting& sighting : track.sightings) {
    if (!track.single_lamp && !(sighting.left && sighting.right)) continue;
    double flux = 0.0;
    bool clipped = false;
    for (const auto& lamp : {sighting.left, sighting.right}) {
      if (!lamp) continue;
      flux += light_of(*lamp).flux;
      const bool bound = lamp->saturated_px > 0 || has(lamp->defects, Defect::saturated);
      const bool measured =
          lamp->lamp && !lamp->lamp->coded && !has(lamp->defects, Defect::bad_fit);
      clipped = clipped || (bound && !measured) || has(lamp->defects, Defect::cut_by_edge);
    }
    frames.clipped += clipped;
    if (clipped || !(flux > 0.0)) continue;
    frames.series.time_s.push_back(seconds_of(sighting.time));
    frames.series.power_w.push_back(flux);
  }
  return frames;
}

// Keeps the frames of the part that the trajectory was fitted to, within 30 degrees of incidence.
PowerSeries within_incidence(const PowerSeries& all, const PowerCase& known,
                             const Trajectory& trajectory) {
  const double widest = std::tan(radians_from_degrees(30.0));
  PowerSeries kept;
  for (std::size_t i = 0; i < all.time_s.size(); ++i) {
    if (all.time_s[i] < trajectory.from_s || all.time_s[i] > trajectory.to_s) continue;
    const double ahead_m = trajectory.at(all.time_s[i]).range_m - known.receiver_m.x();
    if (known.bend == 0.0 ? ahead_m * widest <= known.perpendicular_m() : ahead_m <= 0.0) continue;
    kept.time_s.push_back(all.time_s[i]);
    kept.power_w.push_back(all.power_w[i]);
  }
  return kept;
}

// ln K from the trajectory's distances; its error is that of the trajectory's scale.
void fit_gain(const PowerSeries& series, const Trajectory& trajectory, PowerCase& known) {
  double log_power = 0.0, log_distance = 0.0;
  for (std::size_t i = 0; i < series.time_s.size(); ++i) {
    const MotionState state = trajectory.at(series.time_s[i]);
    const Eigen::Vector3d lamp_m(state.range_m, state.lateral_m, trajectory.lamp_height_m());
    log_power += std::log(series.power_w[i]);
    log_distance += std::log((lamp_m - known.receiver_m).norm());
  }
  const auto n = static_cast<double>(series.time_s.size());
  known.law.gain_w = std::exp((log_power + known.law.path_loss_exponent * log_distance) / n);
  known.log_gain_std = known.law.path_loss_exponent * trajectory.scale_std();
  known.log_gain_per_exponent = log_distance / n;
}

Outcome<PowerSpeed> camera_speed(const VehicleTrack& track, const Site& site,
                                 const Trajectory* trajectory, MethodResult& method) {
  const auto place = known_place(site, track.direction, trajectory);
  const CameraSite& camera = *site.camera;
  if (!place || (!camera.gain_db && !trajectory)) return Miss::no_scale;
  PowerCase known;
  known.law.path_loss_exponent = camera.path_loss_exponent.mean;
  known.exponent_std = camera.path_loss_exponent.std;
  for (int axis = 0; axis < 3; ++axis)
    known.receiver_m[axis] = camera.position_m[static_cast<std::size_t>(axis)].mean;
  known.lateral_m = place->lateral_m;
  known.lamp_height_m = place->lamp_height_m;
  if (site.road.radius_m) {
    known.bend = bend_of(site.road);
    known.straight_m = bend_begins_m(site.road);
    known.radius_m = *site.road.radius_m;
  }
  Frames frames = usable_frames(track);
  if (trajectory) frames.series = within_incidence(frames.series, known, *trajectory);
  const PowerSeries& series = frames.series;
  method.samples = static_cast<std::int64_t>(series.time_s.size());
  if (series.time_s.size() < kFewestFrames)
    return frames.clipped > 0 ? Miss::saturated : Miss::too_few_samples;
  if (series.time_s.back() - series.time_s.front() < kShortest_s)
    return frames.clipped > 0 ? Miss::saturated : Miss::too_short;
  if (camera.gain_db) {
    method.k_source = "site";
    known.law.gain_w = ratio_from_db(camera.gain_db->mean);
    known.log_gain_std = 0.1 * std::log(10.0) * camera.gain_db->std;
  } else {
    method.k_source = "bearings";
    fit_gain(series, *trajectory, known);
  }
  return power_speed(series, known);
}

struct PhotodiodeLight {
  VehicleLight own;
  PowerCase known;
};

Outcome<PhotodiodeLight> photodiode_light(const VehicleTrack& track, const Site& site,
                                          const VehiclePower& power, const Trajectory* trajectory) {
  const PowerTrace& trace = power.own_light ? *power.own_light : *power.trace;
  if (trace.time_s.empty() || (power.shared && !power.own_light)) return Miss::several_vehicles;
  const auto place = known_place(site, track.direction, trajectory);
  if (!place) return Miss::no_scale;
  const auto found = photodiode_case(site, trace.photodiode, *place);
  if (const Miss* miss = std::get_if<Miss>(&found)) return *miss;
  PhotodiodeLight light;
  light.known = std::get<PowerCase>(found);
  const double from_s = trajectory ? trajectory->from_s : seconds_of(track.sightings.front().time);
  const double to_s = trajectory ? trajectory->to_s : seconds_of(track.sightings.back().time);
  const double offset_s =
      site.photodiodes.at(static_cast<std::size_t>(trace.photodiode)).time_offset_s.mean;
  light.known.log_gain_std = std::hypot(light.known.log_gain_std,
                                        log_light_std(trace, from_s - offset_s, to_s - offset_s));
  light.own = vehicle_light(trace, site, light.known, from_s, to_s, trajectory);
  const PowerSeries& series = light.own.series;
  if (series.time_s.size() < 10) return Miss::too_few_samples;
  if (series.time_s.back() - series.time_s.front() < kShortest_s) return Miss::too_short;
  return light;
}

void put(const Outcome<PowerSpeed>& outcome, MethodResult& method) {
  if (const Miss* miss = std::get_if<Miss>(&outcome))
    method.speed = *miss;
  else
    method.speed = std::get<PowerSpeed>(outcome).speed;
}

}  // namespace

MethodResult camera_intensity_method(const VehicleTrack& track, const Site& site,
                                     const Trajectory* trajectory) {
  MethodResult method;
  method.method =
      site.road.kind == RoadKind::curved ? Method::curved_angle_camera : Method::power_slope_camera;
  put(camera_speed(track, site, trajectory, method), method);
  return method;
}

std::vector<MethodResult> photodiode_methods(const VehicleTrack& track, const Site& site,
                                             std::span<const VehiclePower> power,
                                             const Trajectory* trajectory) {
  const Method paper = site.road.kind == RoadKind::curved ? Method::curved_angle_photodiode
                                                          : Method::power_slope_photodiode;
  std::vector<MethodResult> best(2);
  for (const VehiclePower& offered : power) {
    const auto light = photodiode_light(track, site, offered, trajectory);
    for (std::size_t i = 0; i < best.size(); ++i) {
      MethodResult row;
      row.method = i == 0 ? paper : Method::ml_photodiode;
      if (const Miss* miss = std::get_if<Miss>(&light)) {
        row.speed = *miss;
      } else {
        const auto& [own, known] = std::get<PhotodiodeLight>(light);
        row.k_source = "site";
        row.samples = static_cast<std::int64_t>(own.series.time_s.size());
        put(i == 0 ? power_speed(own.cleared, known) : ml_speed(own.series, known), row);
      }
      const auto* speed = std::get_if<SpeedEstimate>(&row.speed);
      const auto* surest = std::get_if<SpeedEstimate>(&best[i].speed);
      if (&offered == &power.front() || (speed && (!surest || speed->std_mps < surest->std_mps)))
        best[i] = row;
    }
  }
  return best;
}

}  // namespace vildar
