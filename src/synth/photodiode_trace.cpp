#include "synth/photodiode_trace.h"

#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "core/error.h"
#include "core/random.h"
#include "optics/channel.h"
#include "synth/light.h"

namespace vildar {
namespace {

Eigen::Vector3d place_of(const PhotodiodeSite& photodiode) {
  return {photodiode.position_m[0].mean, photodiode.position_m[1].mean,
          photodiode.position_m[2].mean};
}

bool in_view(const PhotodiodeSite& photodiode, const Eigen::Vector3d& direction) {
  const double level = std::cos(photodiode.pitch_rad);
  const Eigen::Vector3d axis(level * std::cos(photodiode.yaw_rad),
                             level * std::sin(photodiode.yaw_rad), std::sin(photodiode.pitch_rad));
  return direction.dot(axis) >= direction.norm() * std::cos(photodiode.half_field_of_view_rad);
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

double total_w(const Scenario& scenario, const PhotodiodeSite& photodiode, double time_s) {
  double sum_w = 0.0;
  for (std::size_t i = 0; i < scenario.vehicles.size(); ++i)
    sum_w += vehicle_power_w(scenario, i, photodiode, time_s);
  return sum_w;
}

}  // namespace

double vehicle_power_w(const Scenario& scenario, std::size_t index,
                       const PhotodiodeSite& photodiode, double time_s) {
  const VehicleScene& vehicle = scenario.vehicles[index];
  const VehicleState state = state_at(vehicle, scenario.site.road, time_s);
  const Eigen::Vector3d sensor_m = place_of(photodiode);
  const Eigen::Vector3d lamp_m(state.place_m.x(), state.place_m.y(), vehicle.lamp_height_m);
  const Eigen::Vector3d way_m = lamp_m - sensor_m;
  if (!lamps_face(vehicle, state, sensor_m) || !in_view(photodiode, way_m)) return 0.0;
  if (hidden_by_others(scenario, index, lamp_m, sensor_m, time_s)) return 0.0;
  return vehicle.power_ratio * photodiode.gain_ratio.mean *
         law_of(scenario).power_w(way_m.x(), way_m.tail<2>().norm());
}

RenderedTrace render_trace(const Scenario& scenario) {
  const PhotodiodeScene& scene = scenario.photodiode;
  const std::vector<PhotodiodeSite>& photodiodes = scenario.site.photodiodes;
  RenderedTrace trace;
  const double offset_s = photodiodes.front().time_offset_s.mean;
  trace.noise_w = scene.noise_w;
  if (scene.snr_db) {
    const double first_w = total_w(scenario, photodiodes.front(), offset_s);
    if (!(first_w > 0.0))
      throw ConfigError(
          {{scenario.file.string(), 0, "photodiode.snr_db",
            "no vehicle lights the first photodiode at t = 0, so the ratio has no meaning",
            "give noise_w instead, or start a vehicle in its field of view"}});
    trace.noise_w = first_w * std::pow(10.0, -*scene.snr_db / 20.0);
  }
  const auto samples = static_cast<std::size_t>(std::llround(scenario.duration_s * scene.rate_hz));
  trace.time_s.resize(samples);
  trace.power_w.assign(photodiodes.size(), std::vector<double>(samples));
  Random random(scenario.seed);
  for (std::size_t i = 0; i < samples; ++i) {
    trace.time_s[i] = static_cast<double>(i) / scene.rate_hz;
    for (std::size_t p = 0; p < photodiodes.size(); ++p) {
      double power_w =
          scene.ambient_w + total_w(scenario, photodiodes[p], trace.time_s[i] + offset_s);
      if (trace.noise_w > 0.0) power_w += random.normal(0.0, trace.noise_w);
      trace.power_w[p][i] = power_w;
    }
  }
  return trace;
}

std::string trace_csv(const Scenario& scenario, const RenderedTrace& trace) {
  std::string text = "t_s";
  if (trace.power_w.size() == 1) {
    text += ",power_w";
  } else {
    for (const PhotodiodeSite& photodiode : scenario.site.photodiodes)
      text += "," + photodiode.id + "_power_w";
  }
  text += '\n';
  // Enough decimals of time to tell neighbours apart at 100 kHz and odd rates.
  char cell[64];
  for (std::size_t i = 0; i < trace.time_s.size(); ++i) {
    std::snprintf(cell, sizeof cell, "%.9g", trace.time_s[i]);
    text += cell;
    for (const std::vector<double>& power_w : trace.power_w) {
      std::snprintf(cell, sizeof cell, ",%.*g", scenario.photodiode.digits, power_w[i]);
      text += cell;
    }
    text += '\n';
  }
  return text;
}

}  // namespace vildar
