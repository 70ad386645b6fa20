#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

#include "estimate/contradictions.h"
#include "estimate/delay_light.h"
#include "estimate/lane_choice.h"
#include "estimate/ml_speed.h"
#include "estimate/photodiode_speed.h"
#include "estimate/speed_gate.h"
#include "estimate/vehicle.h"

namespace vildar {
namespace {

// Without a camera the lane is not seen: the nearest one whose headlamps face the photodiode.
const LaneSite* nearest_oncoming(const RoadSite& road, double receiver_y_m) {
  const LaneSite* nearest = nullptr;
  double least_m = std::numeric_limits<double>::infinity();
  for (const LaneSite& lane : road.lanes) {
    const double apart_m = std::abs(lane.lateral_m.mean - receiver_y_m);
    if (lane.direction == Direction::oncoming && apart_m < least_m) {
      least_m = apart_m;
      nearest = &lane;
    }
  }
  return nearest;
}

double peak_w(const PowerTrace& trace, const PowerPass& pass) {
  const auto begin = trace.time_s.begin();
  const auto first = std::lower_bound(begin, trace.time_s.end(), pass.from_s) - begin;
  const auto last = std::upper_bound(begin, trace.time_s.end(), pass.to_s) - begin;
  double most_w = 0.0;
  for (auto i = first; i < last; ++i)
    most_w = std::max(
        most_w, static_cast<double>(trace.power_w[static_cast<std::size_t>(i)]) - trace.ambient_w);
  return most_w;
}

// The trace of this pass whose photodiode receives most, and so sees it best.
const PowerTrace& brightest(std::span<const PowerTrace> traces, const PowerPass& pass) {
  const PowerTrace* best = &traces.front();
  double best_ratio = -1.0;
  for (const PowerTrace& trace : traces) {
    const double ratio = peak_w(trace, pass) / std::max(trace.noise_sigma_w, 1e-300);
    if (ratio > best_ratio) {
      best_ratio = ratio;
      best = &trace;
    }
  }
  return *best;
}

// The stretch of one trace in which the power laws hold, and what is known of it.
struct PassLight {
  PowerSeries series;
  PowerCase known;
};

// Vehicles behind are further away before this one is past than when it is: they add less than
// `others_w`, but of a shape that looks like a slower vehicle. What they add more than a twentieth
// to is left out; in the rest it is a constant background, not known better than it is bright.
void keep_own_light(PowerSeries& series, double others_w) {
  constexpr double kTimesOthers = 20.0;
  constexpr double kMean_s = 0.010;
  std::size_t first = series.time_s.size();
  double sum_w = 0.0;
  for (std::size_t from = first, to = first; from-- > 0;) {
    sum_w += series.power_w[from];
    while (series.time_s[to - 1] - series.time_s[from] > kMean_s) sum_w -= series.power_w[--to];
    if (sum_w < kTimesOthers * others_w * static_cast<double>(to - from)) break;
    first = from;
  }
  const auto cut = static_cast<std::ptrdiff_t>(first);
  series.time_s.erase(series.time_s.begin(), series.time_s.begin() + cut);
  series.power_w.erase(series.power_w.begin(), series.power_w.begin() + cut);
  series.background_std_w = std::hypot(series.background_std_w, others_w);
}

Outcome<PassLight> light_of_pass(const PowerPass& pass, const Site& site, const PowerTrace& trace,
                                 const LaneSite* lane) {
  constexpr double kShortest_s = 0.1;
  if (!lane) return Miss::no_scale;
  const auto place = place_of(*lane, site);
  if (!place) return Miss::no_scale;
  const auto known = photodiode_case(site, trace.photodiode, *place);
  if (const Miss* miss = std::get_if<Miss>(&known)) return *miss;
  PassLight light;
  light.known = std::get<PowerCase>(known);
  const double offset_s =
      site.photodiodes.at(static_cast<std::size_t>(trace.photodiode)).time_offset_s.mean;
  light.series = usable_power(trace, site, light.known, pass.from_s + offset_s,
                              pass.peak_s + offset_s, nullptr);
  constexpr std::size_t kFewest = 10;
  if (light.series.time_s.size() < kFewest) return Miss::too_few_samples;
  if (pass.others_w > 0.0) {
    keep_own_light(light.series, pass.others_w);
    if (light.series.time_s.size() < kFewest) return Miss::several_vehicles;
  }
  if (light.series.time_s.back() - light.series.time_s.front() < kShortest_s)
    return Miss::too_short;
  return light;
}

// What a method found, beside the row it gets.
struct Found {
  MethodResult row;
  std::optional<double> range_m, acceleration_mps2, chi2_per_dof;
};

Found power_method(Method method, const Outcome<PassLight>& light,
                   Outcome<PowerSpeed> (*speed_of)(const PowerSeries&, const PowerCase&)) {
  Found found{{method, Miss::unobservable, 0, "site"}, {}, {}, {}};
  if (const Miss* miss = std::get_if<Miss>(&light)) {
    found.row.speed = *miss;
    return found;
  }
  const auto& [series, known] = std::get<PassLight>(light);
  found.row.samples = static_cast<std::int64_t>(series.time_s.size());
  const auto outcome = speed_of(series, known);
  if (const Miss* miss = std::get_if<Miss>(&outcome)) {
    found.row.speed = *miss;
  } else {
    found.row.speed = std::get<PowerSpeed>(outcome).speed;
    found.range_m = std::get<PowerSpeed>(outcome).range_m;
  }
  return found;
}

Found delay_method(const PowerPass& pass, const Site& site, std::span<const PowerTrace> traces,
                   double offset_s) {
  std::vector<const PowerTrace*> all;
  for (const PowerTrace& trace : traces) all.push_back(&trace);
  const auto outcome = delay_speed(site, all, pass.from_s + offset_s, pass.to_s + offset_s);
  Found found{delay_row(outcome), {}, {}, {}};
  if (const auto* fit = std::get_if<DelayFit>(&outcome)) {
    found.acceleration_mps2 = fit->acceleration_mps2;
    found.chi2_per_dof = fit->chi2_per_dof;
  }
  return found;
}

// The surest of the methods that measured; the first one's reason where none did.
void stand_by_surest(const std::vector<Found>& methods, VehicleResult& result) {
  const Found* surest = nullptr;
  for (const Found& found : methods) {
    result.methods.push_back(found.row);
    const auto* speed = std::get_if<SpeedEstimate>(&found.row.speed);
    if (speed && (!surest || speed->std_mps < std::get<SpeedEstimate>(surest->row.speed).std_mps))
      surest = &found;
  }
  // Where they contradict each other, the delay stands: no lamp and no channel enters it.
  for (const Found& found : methods) {
    const auto* speed = std::get_if<SpeedEstimate>(&found.row.speed);
    if (speed && found.row.method == Method::delay_photodiodes && useful(*speed) &&
        apart(*speed, std::get<SpeedEstimate>(surest->row.speed)))
      surest = &found;
  }
  if (!surest) {
    result.method = methods.front().row.method;
    result.withheld = std::get<Miss>(methods.front().row.speed);
    return;
  }
  result.method = surest->row.method;
  result.speed = std::get<SpeedEstimate>(surest->row.speed);
  result.n_pd_samples = surest->row.samples;
  if (!useful(result.speed)) {
    result.withheld = Miss::too_uncertain;
    return;
  }
  result.closing_speed_mps = result.speed.speed_mps;
  result.range_ref_m = surest->range_m;
  result.acceleration_mps2 = surest->acceleration_mps2;
  if (surest->chi2_per_dof) result.chi2_per_dof["photodiode"] = *surest->chi2_per_dof;
}

// A method that the others contradict by more than their intervals is named.
void warn_of_contradictions(VehicleResult& result) {
  if (result.withheld) return;
  for (const MethodResult& row : result.methods) {
    const auto* speed = std::get_if<SpeedEstimate>(&row.speed);
    if (!speed || row.method == result.method) continue;
    if (apart(*speed, result.speed))
      result.warnings.push_back(std::string(name_of(row.method)) + " disagrees with " +
                                std::string(name_of(result.method)) +
                                " beyond their intervals; check the channel and the lanes");
  }
}

}  // namespace

VehicleResult estimate_pass(const PowerPass& pass, int pass_number, const Site& site,
                            std::span<const PowerTrace> traces) {
  if (traces.empty()) throw std::invalid_argument("estimate_pass: no photodiode trace given");
  const PowerTrace& trace = brightest(traces, pass);
  const PhotodiodeSite& receiver = site.photodiodes.at(static_cast<std::size_t>(trace.photodiode));
  const LaneSite* lane = nearest_oncoming(site.road, receiver.position_m[1].mean);
  const double offset_s = receiver.time_offset_s.mean;
  VehicleResult result;
  result.track_id = pass_number;
  result.t_first_s = pass.from_s + offset_s;
  result.t_last_s = pass.to_s + offset_s;
  result.used_photodiode = true;
  if (lane) result.lane = lane->id;
  const bool curved = site.road.kind == RoadKind::curved;
  const auto light = light_of_pass(pass, site, trace, lane);
  std::vector<Found> methods{
      power_method(curved ? Method::curved_angle_photodiode : Method::power_slope_photodiode, light,
                   power_speed),
      power_method(Method::ml_photodiode, light, ml_speed)};
  if (traces.size() > 1) methods.push_back(delay_method(pass, site, traces, offset_s));
  stand_by_surest(methods, result);
  constexpr double kOthersMatter = 0.01;  // of the brightest light
  const bool of_the_site =
      result.withheld == Miss::no_scale || result.withheld == Miss::outside_model;
  if (result.withheld && !of_the_site && pass.others_w > kOthersMatter * peak_w(trace, pass))
    result.withheld = Miss::several_vehicles;
  if (!result.withheld && lane && !curved) result.lateral_m = lane->lateral_m.mean;
  warn_of_contradictions(result);
  if (result.withheld == Miss::no_scale)
    result.warnings.push_back(
        "speed is unobservable: light alone needs channel.gain_db and path_loss_exponent with "
        "lamps.height_m and a lane, or a second photodiode a known distance up the road");
  return result;
}

}  // namespace vildar
