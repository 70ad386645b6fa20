#pragma once

#include <array>
#include <cmath>

#include "simulated_pass.h"
#include "types/power.h"

namespace vildar::simulated {

/// A headlamp that no estimator knows: Gaussian in azimuth, exponential in elevation, and up to
/// `ripple` nat of cosines.
struct Beam {
  double width = 11.4, tilt = 9.0;
  std::array<double, 6> waves{};
};

inline Beam random_beam(double ripple, Random& random) {
  Beam beam;
  beam.width = random.normal(11.4, 2.5);
  beam.tilt = random.normal(9.0, 3.0);
  for (std::size_t k = 0; k < beam.waves.size(); ++k)
    beam.waves[k] = ripple * random.normal() / static_cast<double>(k + 1);
  return beam;
}

/// Light that both lamps of a vehicle send to a place, relative units.
inline double beam_power(const Vehicle& vehicle, const RoadSite& road, const Beam& beam,
                         const Eigen::Vector3d& receiver_m, double t_s) {
  const Lamps lamps = lamps_at(vehicle, road, t_s);
  const Eigen::Vector3d across_m = lamps.left_m - lamps.right_m;
  const double heading_rad = std::atan2(-across_m.x(), across_m.y());
  double sum = 0.0;
  for (const Eigen::Vector3d& lamp_m : {lamps.left_m, lamps.right_m}) {
    const Eigen::Vector3d apart_m = lamp_m - receiver_m;
    if (apart_m.x() <= 0.0) continue;
    const double azimuth_rad = std::atan2(apart_m.y(), apart_m.x()) - heading_rad;
    const double elevation_rad = std::atan2(-apart_m.z(), std::hypot(apart_m.x(), apart_m.y()));
    double log_intensity = -beam.width * azimuth_rad * azimuth_rad - beam.tilt * elevation_rad;
    for (std::size_t k = 0; k < beam.waves.size(); ++k)
      log_intensity +=
          beam.waves[k] * std::cos(static_cast<double>(k + 1) * kPi * azimuth_rad / 0.45);
    sum += 0.5 * std::exp(log_intensity) * apart_m.x() / std::pow(apart_m.norm(), 3);
  }
  return sum;
}

struct Receiving {
  double snr_db = 40.0;        ///< 20 log10 of the power at t = 0 over a sample's noise
  double ambient_share = 0.5;  ///< of the power at t = 0
  double gain = 1.0;           ///< relative to the other photodiodes
  double angular_gain = 0.0;   ///< relative change of the gain at 0.35 rad off the axis of the road
  double time_offset_s = 0.0;  ///< clip time less photodiode time
  double from_s = -0.5, latest_s = 8.0;
  double until_m = -5.0;  ///< of the vehicle's path
};

/// Trace at 1 kHz of one photodiode of the site, white noise.
inline PowerTrace beam_trace(const Vehicle& vehicle, const Site& site, const Beam& beam,
                             int photodiode, const Receiving& receiving, Random& random) {
  const auto& place = site.photodiodes[static_cast<std::size_t>(photodiode)].position_m;
  const Eigen::Vector3d receiver_m(place[0].mean, place[1].mean, place[2].mean);
  const double first = beam_power(vehicle, site.road, beam, receiver_m, 0.0);
  PowerTrace trace;
  trace.photodiode = photodiode;
  trace.photodiode_id = site.photodiodes[static_cast<std::size_t>(photodiode)].id;
  trace.sample_period_s = 1e-3;
  trace.noise_sigma_w = first * std::pow(10.0, -receiving.snr_db / 20.0);
  trace.ambient_w = receiving.ambient_share * first;
  trace.ambient_sigma_w = trace.noise_sigma_w / 20.0;
  for (double t_s = receiving.from_s;
       vehicle.along_at_m(t_s) > receiving.until_m && t_s < receiving.latest_s; t_s += 1e-3) {
    const Eigen::Vector3d apart_m = lamps_at(vehicle, site.road, t_s).middle_m - receiver_m;
    const double off_axis_rad =
        std::atan2(std::hypot(apart_m.y(), apart_m.z()), std::max(0.01, apart_m.x()));
    const double gain = receiving.gain * (1.0 + receiving.angular_gain * off_axis_rad / 0.35);
    trace.time_s.push_back(t_s - receiving.time_offset_s);
    trace.power_w.push_back(
        static_cast<float>(gain * beam_power(vehicle, site.road, beam, receiver_m, t_s) +
                           trace.ambient_w + trace.noise_sigma_w * random.normal()));
  }
  return trace;
}

}  // namespace vildar::simulated
