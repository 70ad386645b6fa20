#pragma once

#include <cmath>

#include "core/quantity.h"
#include "estimate/power_method.h"

namespace vildar::law_pass {

inline constexpr double kSpeed_mps = 20.0, kAlong_m = 35.0;
inline constexpr double kEdge_rad = 0.45;  ///< half a turn of the first cosine

/// A mast of 4 m beside a lane; the power law, its gain known to a tenth.
inline PowerCase case_of() {
  PowerCase known;
  known.law = {1.0, 2.0, 0.0};
  known.log_gain_std = 0.1;
  known.receiver_m = {0.0, 0.0, 4.0};
  known.lateral_m = {-4.0, 0.3};
  known.lamp_height_m = {0.65, 0.05};
  return known;
}

inline PassMotion motion_of() { return {0.0, kSpeed_mps, kAlong_m, 0.0}; }

/// Without noise, from 60 to 10 m; the beam has one cosine of the azimuth.
inline PowerSeries light_of(int wave, double ripple_nat) {
  PowerSeries series;
  for (double t_s = -1.25; t_s < 1.25; t_s += 1e-3) {
    const double ahead_m = kAlong_m - kSpeed_mps * t_s;
    const double unlike = ripple_nat * std::cos(wave * kPi * std::atan2(4.0, ahead_m) / kEdge_rad);
    series.time_s.push_back(t_s);
    series.power_w.push_back(std::exp(unlike) / (ahead_m * ahead_m + 4.0 * 4.0 + 3.35 * 3.35));
  }
  return series;
}

}  // namespace vildar::law_pass
