#include <cmath>
#include <limits>
#include <stdexcept>

#include "estimate/lane_choice.h"
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

// The trace of this pass whose photodiode receives most, and so sees it best.
const PowerTrace& brightest(std::span<const PowerTrace> traces, const PowerPass& pass) {
  const PowerTrace* best = &traces.front();
  double best_ratio = -1.0;
  for (const PowerTrace& trace : traces) {
    double peak_w = 0.0;
    for (std::size_t i = 0; i < trace.time_s.size(); ++i)
      if (trace.time_s[i] >= pass.from_s && trace.time_s[i] <= pass.to_s)
        peak_w = std::max(peak_w, static_cast<double>(trace.power_w[i]) - trace.ambient_w);
    const double ratio = peak_w / std::max(trace.noise_sigma_w, 1e-300);
    if (ratio > best_ratio) {
      best_ratio = ratio;
      best = &trace;
    }
  }
  return *best;
}

Outcome<PowerSpeed> speed_of_pass(const PowerPass& pass, const Site& site, const PowerTrace& trace,
                                  const LaneSite* lane, MethodResult& method) {
  constexpr double kShortest_s = 0.1;
  if (!lane) return Miss::no_scale;
  const auto place = place_of(*lane, site);
  if (!place) return Miss::no_scale;
  const auto known = photodiode_case(site, trace.photodiode, *place);
  if (const Miss* miss = std::get_if<Miss>(&known)) return *miss;
  const auto& power_case = std::get<PowerCase>(known);
  const double offset_s =
      site.photodiodes.at(static_cast<std::size_t>(trace.photodiode)).time_offset_s.mean;
  const PowerSeries series = usable_power(trace, site, power_case, pass.from_s + offset_s,
                                          pass.peak_s + offset_s, nullptr);
  method.samples = static_cast<std::int64_t>(series.time_s.size());
  if (series.time_s.size() < 10) return Miss::too_few_samples;
  if (series.time_s.back() - series.time_s.front() < kShortest_s) return Miss::too_short;
  return power_speed(series, power_case);
}

}  // namespace

VehicleResult estimate_pass(const PowerPass& pass, int pass_number, const Site& site,
                            std::span<const PowerTrace> traces) {
  if (traces.empty()) throw std::invalid_argument("estimate_pass: no photodiode trace given");
  const PowerTrace& trace = brightest(traces, pass);
  const PhotodiodeSite& receiver = site.photodiodes.at(static_cast<std::size_t>(trace.photodiode));
  const LaneSite* lane = nearest_oncoming(site.road, receiver.position_m[1].mean);
  VehicleResult result;
  result.track_id = pass_number;
  result.t_first_s = pass.from_s + receiver.time_offset_s.mean;
  result.t_last_s = pass.to_s + receiver.time_offset_s.mean;
  result.used_photodiode = true;
  result.method = site.road.kind == RoadKind::curved ? Method::curved_angle_photodiode
                                                     : Method::power_slope_photodiode;
  if (lane) result.lane = lane->id;
  MethodResult method{result.method, Miss::unobservable, 0, "site"};
  const auto outcome = speed_of_pass(pass, site, trace, lane, method);
  result.n_pd_samples = method.samples;
  if (const Miss* miss = std::get_if<Miss>(&outcome)) {
    method.speed = *miss;
    result.withheld = *miss;
  } else {
    const auto& found = std::get<PowerSpeed>(outcome);
    method.speed = found.speed;
    result.speed = found.speed;
    if (!useful(found.speed)) {
      result.withheld = Miss::too_uncertain;
    } else {
      result.range_ref_m = found.range_m;
      result.closing_speed_mps = found.speed.speed_mps;
      if (site.road.kind == RoadKind::straight) result.lateral_m = lane->lateral_m.mean;
    }
  }
  result.methods.push_back(method);
  return result;
}

}  // namespace vildar
