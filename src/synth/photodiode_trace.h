#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "synth/scenario.h"

namespace vildar {

/// Power that one photodiode receives from one vehicle at clip time `time_s`, by the power law of
/// the site's channel: K times lamp power, D from the photodiode to the vehicle's place at lamp
/// height, cos(theta) = R / D. Zero where the vehicle is outside the field of view, its lamps look
/// the other way, or another body hides it. Throws std::invalid_argument where the site lacks the
/// channel.
double vehicle_power_w(const Scenario& scenario, std::size_t vehicle,
                       const PhotodiodeSite& photodiode, double time_s);

/// What the photodiodes of a scenario record: all vehicles, ambient light, white noise.
struct RenderedTrace {
  std::vector<double> time_s;                ///< photodiode clock
  std::vector<std::vector<double>> power_w;  ///< [photodiode][sample]
  double noise_w = 0.0;                      ///< standard deviation of one sample
};

/// Throws ConfigError where a noise in decibels is asked for and no vehicle is received at the
/// first sample of the first photodiode.
RenderedTrace render_trace(const Scenario& scenario);

/// The trace as the contract's CSV (section 3).
std::string trace_csv(const Scenario& scenario, const RenderedTrace& trace);

}  // namespace vildar
