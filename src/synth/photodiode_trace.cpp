#include "synth/photodiode_trace.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "optics/atmosphere.h"
#include "optics/channel.h"
#include "optics/incidence.h"
#include "synth/light.h"

namespace vildar {
namespace {

Eigen::Vector3d place_of(const PhotodiodeSite& photodiode) {
  return {photodiode.position_m[0].mean, photodiode.position_m[1].mean,
          photodiode.position_m[2].mean};
}

bool in_view(const PhotodiodeSite& photodiode, const Eigen::Vector3d& direction) {
  return direction.dot(axis_of(photodiode)) >=
         direction.norm() * std::cos(photodiode.half_field_of_view_rad);
}

PowerLaw law_of(const Scenario& scenario) {
  const auto& channel = scenario.site.channel;
  if (!channel || !channel->gain_db || !channel->path_loss_exponent)
    throw std::invalid_argument(
        "photodiode trace: channel.gain_db or path_loss_exponent is missing");
  PowerLaw law;
  law.gain_w = ratio_from_db(channel->gain_db->mean) * channel->lamp_power_w.mean;
  law.path_loss_exponent = channel->path_loss_exponent->mean;
  if (channel->half_power_angle_rad)
    law.cosine_exponent = lambertian_order(Radians(*channel->half_power_angle_rad)) + 1.0;
  return law;
}

// Sum over the lamps by their beam.
double beam_power_w(const Scenario& scenario, const VehicleScene& vehicle,
                    const VehicleState& state, const PhotodiodeSite& photodiode, double time_s) {
  const Eigen::Vector3d sensor_m = place_of(photodiode);
  const Eigen::Vector3d axis = axis_of(photodiode);
  double sum_lx = 0.0;
  for (const Eigen::Vector3d& lamp_m : lamp_positions_m(vehicle, state)) {
    const Eigen::Vector3d way_m = lamp_m - sensor_m;
    const double distance_m = way_m.norm();
    const double incidence = std::max(0.0, axis.dot(way_m) / distance_m);
    sum_lx += lamp_intensity_cd(vehicle, state, lamp_m, sensor_m, time_s) * incidence /
              (distance_m * distance_m) *
              transmittance(scenario.extinction_per_m, Metres(distance_m));
  }
  return sum_lx * photodiode.area_m2.value() / scenario.site.channel->luminous_efficacy_lm_per_w;
}

}  // namespace

double vehicle_power_w(const Scenario& scenario, const std::vector<VehicleState>& states,
                       std::size_t index, const PhotodiodeSite& photodiode, double time_s) {
  const VehicleScene& vehicle = scenario.vehicles[index];
  const VehicleState& state = states[index];
  const Eigen::Vector3d sensor_m = place_of(photodiode);
  const Eigen::Vector3d lamp_m(state.place_m.x(), state.place_m.y(), vehicle.lamp_height_m);
  const Eigen::Vector3d way_m = lamp_m - sensor_m;
  if (!lamps_face(vehicle, state, sensor_m) || !in_view(photodiode, way_m)) return 0.0;
  if (hidden_by_others(scenario, states, index, lamp_m, sensor_m)) return 0.0;
  if (scenario.site.channel && !scenario.site.channel->beam.empty())
    return photodiode.gain_ratio.mean * beam_power_w(scenario, vehicle, state, photodiode, time_s);
  return vehicle.power_ratio * photodiode.gain_ratio.mean *
         law_of(scenario).power_w(way_m.x(), way_m.tail<2>().norm()) *
         transmittance(scenario.extinction_per_m, Metres(way_m.norm()));
}

double street_lamp_power_w(const Scenario& scenario, const std::vector<VehicleState>& states,
                           std::size_t lamp, const PhotodiodeSite& photodiode, double time_s) {
  if (!photodiode.area_m2) return 0.0;
  Emitter emitter;
  emitter.lamp = lamp;
  const Eigen::Vector3d sensor_m = place_of(photodiode);
  const Eigen::Vector3d lamp_m = emitter_position_m(scenario, emitter, time_s);
  const Eigen::Vector3d way_m = lamp_m - sensor_m;
  if (!in_view(photodiode, way_m)) return 0.0;
  for (std::size_t i = 0; i < states.size(); ++i)
    if (body_hides(scenario.vehicles[i], states[i], lamp_m, sensor_m)) return 0.0;
  const double incidence = std::max(0.0, axis_of(photodiode).dot(way_m.normalized()));
  const double efficacy = scenario.site.channel ? scenario.site.channel->luminous_efficacy_lm_per_w
                                                : ChannelSite{}.luminous_efficacy_lm_per_w;
  return photodiode.gain_ratio.mean * scenario.street_lamps[lamp].intensity_cd * incidence *
         *photodiode.area_m2 / (way_m.squaredNorm() * efficacy) *
         transmittance(scenario.extinction_per_m, Metres(way_m.norm()));
}

double light_w(const Scenario& scenario, const PhotodiodeSite& photodiode, double time_s,
               double window_s) {
  const PhotodiodeScene& scene = scenario.photodiode;
  const auto level = [&](const Waveform& wave) {
    return window_s > 0.0 ? wave.mean(time_s - 0.5 * window_s, time_s + 0.5 * window_s)
                          : wave.at(time_s);
  };
  double sum_w = scene.ambient_w;
  if (scene.ambient_flicker > 0.0)
    sum_w *= level(Waveform::sine(2.0 * scenario.site.mains_hz, scene.ambient_flicker, 0.0));
  const std::vector<VehicleState> states = states_at(scenario, time_s);
  for (std::size_t i = 0; i < states.size(); ++i)
    sum_w += vehicle_power_w(scenario, states, i, photodiode, time_s) *
             level(scenario.vehicles[i].waveform);
  for (std::size_t i = 0; i < scenario.street_lamps.size(); ++i)
    sum_w += street_lamp_power_w(scenario, states, i, photodiode, time_s) *
             level(scenario.street_lamps[i].waveform);
  return sum_w;
}

}  // namespace vildar
