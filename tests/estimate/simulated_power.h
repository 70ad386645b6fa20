#pragma once

#include <array>

#include "simulated_pass.h"
#include "types/power.h"

namespace vildar::simulated {

/// Trace of the first photodiode: one transmitter at the vehicle's place at lamp height, in the
/// paper's power law with cos(theta) = R / D, on a constant background with white noise.
struct Diode {
  double from_s = -1.0, to_s = 2.5;  ///< clip time
  double rate_hz = 1000.0;
  double gain_w = 1.0, path_loss_exponent = 2.0, cosine_exponent = 0.0;
  double ambient_w = 0.0;
  double noise_w = 0.0;
  double time_offset_s = 0.0;  ///< clip time less photodiode time, the true one
  /// Nat of cosines of the azimuth, the first half a turn at 0.45 rad, by which its beam is unlike
  /// the law.
  std::array<double, 6> waves{};
};

inline PowerTrace trace_of(const Vehicle& vehicle, const Site& site, const Diode& diode,
                           Random& random) {
  const auto& place = site.photodiodes.front().position_m;
  const Eigen::Vector3d receiver_m(place[0].mean, place[1].mean, place[2].mean);
  PowerTrace trace;
  trace.photodiode_id = site.photodiodes.front().id;
  trace.sample_period_s = 1.0 / diode.rate_hz;
  trace.noise_sigma_w = diode.noise_w;
  trace.ambient_w = diode.ambient_w;
  for (int i = 0; i < (diode.to_s - diode.from_s) * diode.rate_hz; ++i) {
    const double t_s = diode.from_s + i / diode.rate_hz;
    const Eigen::Vector3d apart_m = lamps_at(vehicle, site.road, t_s).middle_m - receiver_m;
    double power_w = 0.0;
    if (apart_m.x() > 0.0)
      power_w = diode.gain_w * std::pow(apart_m.norm(), -diode.path_loss_exponent) *
                std::pow(apart_m.x() / apart_m.norm(), diode.cosine_exponent);
    double unlike = 0.0;
    for (std::size_t k = 0; k < diode.waves.size(); ++k)
      unlike += diode.waves[k] * std::cos(static_cast<double>(k + 1) * kPi *
                                          std::atan2(apart_m.y(), apart_m.x()) / 0.45);
    power_w *= std::exp(unlike);
    trace.time_s.push_back(t_s - diode.time_offset_s);
    trace.power_w.push_back(
        static_cast<float>(power_w + diode.ambient_w + diode.noise_w * random.normal()));
  }
  return trace;
}

}  // namespace vildar::simulated
