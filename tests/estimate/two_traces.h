#pragma once

#include <vector>

#include "core/random.h"
#include "types/power.h"

namespace vildar::simulated {

/// What two photodiodes receive from 0 to `to_s` at 1 kHz: `light_w` of the photodiode and the
/// time, and noise.
template <class Light>
std::vector<PowerTrace> two_traces(double to_s, double noise_w, Random& random, Light light_w) {
  constexpr double kPeriod_s = 1e-3;
  std::vector<PowerTrace> traces(2);
  for (int k = 0; k < 2; ++k) {
    PowerTrace& trace = traces[static_cast<std::size_t>(k)];
    trace.photodiode = k;
    trace.sample_period_s = kPeriod_s;
    trace.noise_sigma_w = noise_w;
    trace.ambient_sigma_w = 0.1 * noise_w;
    for (double t_s = 0.0; t_s < to_s; t_s += kPeriod_s) {
      trace.time_s.push_back(t_s);
      trace.power_w.push_back(static_cast<float>(light_w(k, t_s) + noise_w * random.normal()));
    }
  }
  return traces;
}

}  // namespace vildar::simulated
