#include "estimate/photodiode_speed.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "estimate/lane_choice.h"
#include "estimate/light_edges.h"
#include "estimate/pass_posterior.h"
#include "estimate/series_blocks.h"
#include "optics/road.h"

namespace vildar {
namespace {

// tan of the widest incidence angle at which the paper's estimators are used.
const double kWidestTangent = std::tan(radians_from_degrees(30.0));
constexpr double kClearSigmas = 5.0;
constexpr double kPowerBlock_s = 0.010;

bool in_front(const PowerCase& known, double mean_w, double time_s, const Trajectory* trajectory) {
  const double d_m = known.perpendicular_m();
  double range_m;
  if (trajectory) {
    const MotionState state = trajectory->at(time_s);
    if (!(state.over_ground_mps > 0.0)) return false;
    range_m = state.range_m - known.receiver_m.x();
  } else {
    const double distance_m =
        std::pow(mean_w / known.law.gain_w, -1.0 / known.law.path_loss_exponent);
    if (known.bend != 0.0) return true;
    if (!(distance_m > d_m)) return false;
    range_m = std::sqrt(distance_m * distance_m - d_m * d_m);
  }
  return known.bend != 0.0 ? range_m > 0.0 : range_m * kWidestTangent > d_m;
}

// What a house or the rim of the photodiode's view lets in or takes away at once is no lamp's way.
// Light that is edges all along stays as it is: the fit says what it is worth.
void keep_series_between_edges(PowerSeries& series, std::vector<PowerBlock> blocks) {
  keep_between_edges(blocks, 0.0);
  if (blocks.empty()) return;
  const auto index_of = [&](double time_s) {
    return std::ranges::lower_bound(series.time_s, time_s) - series.time_s.begin();
  };
  const auto first = index_of(blocks.front().time_s - 0.5 * blocks.front().duration_s);
  const auto end = index_of(blocks.back().time_s + 0.5 * blocks.back().duration_s);
  for (auto* values : {&series.time_s, &series.power_w}) {
    values->erase(values->begin() + end, values->end());
    values->erase(values->begin(), values->begin() + first);
  }
}

// Times in clip time, which is photodiode time plus `offset_s`.
PowerSeries usable_power(const PowerTrace& trace, const Uncertain& ambient_w, double offset_s,
                         const PowerCase& known, double from_s, double to_s,
                         const Trajectory* trajectory) {
  PowerSeries series;
  std::vector<PowerBlock> blocks;
  series.background_std_w = ambient_w.std;
  const auto begin = std::lower_bound(trace.time_s.begin(), trace.time_s.end(), from_s - offset_s) -
                     trace.time_s.begin();
  const auto end = std::upper_bound(trace.time_s.begin(), trace.time_s.end(), to_s - offset_s) -
                   trace.time_s.begin();
  // Whole blocks are taken or left: choosing single samples by their noise would bend the slope.
  for (auto first = begin; first < end;) {
    auto last = first;
    double sum_w = 0.0;
    const auto at = [](std::ptrdiff_t i) { return static_cast<std::size_t>(i); };
    while (last < end && trace.time_s[at(last)] < trace.time_s[at(first)] + kPowerBlock_s)
      sum_w += static_cast<double>(trace.power_w[at(last++)]) - ambient_w.mean;
    const double mean_w = sum_w / static_cast<double>(last - first);
    const double time_s = 0.5 * (trace.time_s[at(first)] + trace.time_s[at(last - 1)]) + offset_s;
    if (mean_w > kClearSigmas * trace.noise_sigma_w &&
        in_front(known, mean_w, time_s, trajectory)) {
      const auto samples = static_cast<int>(last - first);
      blocks.push_back(
          {time_s, kPowerBlock_s, mean_w, trace.noise_sigma_w / std::sqrt(samples), samples});
      for (auto i = first; i < last; ++i) {
        series.time_s.push_back(trace.time_s[at(i)] + offset_s);
        series.power_w.push_back(static_cast<double>(trace.power_w[at(i)]) - ambient_w.mean);
      }
    }
    first = last;
  }
  keep_series_between_edges(series, std::move(blocks));
  return series;
}

}  // namespace

VehiclePlace place_of(const Trajectory& trajectory) {
  const PathMatrix& covariance = trajectory.fit.covariance;
  const double scale_m = std::exp(trajectory.fit.parameters[kLogScale]);
  const auto length = [&](int parameter, double mean_m) {
    const double ratio = trajectory.fit.parameters[parameter];
    const double variance =
        covariance(parameter, parameter) +
        ratio * (2.0 * covariance(kLogScale, parameter) + ratio * covariance(kLogScale, kLogScale));
    return Uncertain{mean_m, scale_m * std::sqrt(std::max(0.0, variance))};
  };
  double lateral_m = trajectory.lateral_m();
  if (trajectory.problem.setting.crosses()) {  // where it passes
    const MotionState first = trajectory.at(trajectory.from_s),
                      last = trajectory.at(trajectory.to_s);
    lateral_m = (first.range_m < last.range_m ? first : last).lateral_m;
  }
  return {length(kLateral, lateral_m), length(kDrop, trajectory.lamp_height_m())};
}

std::optional<VehiclePlace> place_of(const LaneSite& lane, const Site& site) {
  if (!site.lamps.height_m) return std::nullopt;
  return VehiclePlace{lane_prior_m(lane), *site.lamps.height_m};
}

Outcome<PowerCase> photodiode_case(const Site& site, int photodiode, const VehiclePlace& place) {
  if (!site.channel) return Miss::no_scale;
  const ChannelSite& channel = *site.channel;
  if (!channel.beam.empty()) return Miss::outside_model;
  if (!channel.gain_db || !channel.path_loss_exponent) return Miss::no_scale;
  const PhotodiodeSite& receiver = site.photodiodes.at(static_cast<std::size_t>(photodiode));
  PowerCase known;
  known.law.gain_w =
      ratio_from_db(channel.gain_db->mean) * channel.lamp_power_w.mean * receiver.gain_ratio.mean;
  known.law.path_loss_exponent = channel.path_loss_exponent->mean;
  if (channel.half_power_angle_rad)
    known.law.cosine_exponent = lambertian_order(Radians(*channel.half_power_angle_rad)) + 1.0;
  if (!(known.law.gain_w > 0.0 && known.law.path_loss_exponent > 0.0)) return Miss::no_scale;
  const double gain_std = 0.1 * std::log(10.0) * channel.gain_db->std;
  const double lamp_std = channel.lamp_power_w.std / channel.lamp_power_w.mean;
  const double ratio_std = receiver.gain_ratio.std / receiver.gain_ratio.mean;
  known.log_gain_std = std::hypot(std::hypot(gain_std, lamp_std), ratio_std);
  known.exponent_std = channel.path_loss_exponent->std;
  for (int axis = 0; axis < 3; ++axis)
    known.receiver_m[axis] = receiver.position_m[static_cast<std::size_t>(axis)].mean;
  known.lateral_m = {place.lateral_m.mean,
                     std::hypot(place.lateral_m.std, receiver.position_m[1].std)};
  known.lamp_height_m = {place.lamp_height_m.mean,
                         std::hypot(place.lamp_height_m.std, receiver.position_m[2].std)};
  if (site.road.radius_m) {
    known.bend = bend_of(site.road);
    known.straight_m = bend_begins_m(site.road);
    known.radius_m = *site.road.radius_m;
  }
  return known;
}

VehicleLight vehicle_light(const PowerTrace& trace, const Site& site, const PowerCase& known,
                           double from_s, double to_s, const Trajectory* trajectory) {
  constexpr double kUnsure = 0.01;  // of the least light
  const double offset_s =
      site.photodiodes.at(static_cast<std::size_t>(trace.photodiode)).time_offset_s.mean;
  const Uncertain ambient_w{trace.ambient_w, trace.ambient_sigma_w};
  VehicleLight light;
  light.series = usable_power(trace, ambient_w, offset_s, known, from_s, to_s, trajectory);
  light.cleared = light.series;
  if (light.series.power_w.empty() || !(ambient_w.std > kUnsure * least_mean_w(light.series)))
    return light;
  const auto outcome = pass_posterior(light.series, known);
  const auto* posterior = std::get_if<PassPosterior>(&outcome);
  if (!posterior) return light;
  const Uncertain told_w{ambient_w.mean + posterior->background_w, posterior->background_std_w};
  // What was too faint above the one ambient, or too near, may not be so above the other.
  PowerSeries cleared = usable_power(trace, told_w, offset_s, known, from_s, to_s, trajectory);
  if (cleared.power_w.empty()) return light;
  light.cleared = light.series = std::move(cleared);
  for (double& power_w : light.series.power_w) power_w += told_w.mean - ambient_w.mean;
  light.series.background_std_w = ambient_w.std;
  return light;
}

}  // namespace vildar
