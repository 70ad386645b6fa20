#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/quantity.h"

namespace vildar::simulate {

/// How "initial SNR" turns the power at t = 0 into the noise of a sample.
enum class SnrKind {
  electrical,  ///< 20 log10(P0 / sigma), the paper's reading
  optical,     ///< 10 log10(P0 / sigma)
};
/// The instant of a window that its estimate is drawn at.
enum class WindowLabel { end, centre, start };

/// Everything that the paper's experiments depend on; the defaults are the paper's.
struct Options {
  double speed_mps = 20.0;
  double start_range_m = 15.0;
  double perpendicular_m = 0.5;
  double duration_s = 0.3;
  double sample_period_s = 1e-3;
  double half_power_angle_deg = 40.0;
  double gain_db = -49.32;
  double path_loss_exponent = 1.21;
  double lambertian_gain_db = -41.39;
  double lambertian_exponent = 1.673;
  double snr_db = 30.0;
  SnrKind snr_kind = SnrKind::electrical;
  WindowLabel label = WindowLabel::end;
  /// Whether the generator multiplies by cos^(n+1)(theta): the paper's text allows both readings.
  bool with_cosine = true;
  bool without_cosine = true;

  double angular_speed_rad_per_s = 1.0;
  double curve_radius_m = 40.0;
  double curve_start_deg = 90.0;
  double curve_duration_s = 0.1;
  double curve_lateral_m = 0.5;  ///< d_o of the second curved-geometry reading

  std::vector<double> durations_s{0.1, 0.2, 0.3, 0.4, 0.5};
  std::vector<double> snrs_db{20.0, 30.0, 40.0, 50.0};
  std::vector<double> speeds_mps{5.0, 10.0, 20.0, 30.0, 40.0};
  std::vector<double> half_power_angles_deg{20.0, 30.0, 40.0, 50.0, 60.0};

  int trials = 400;
  std::uint64_t seed = 1;
  int threads = 0;  ///< 0: as many as the machine has
  bool maximum_likelihood = true;

  /// Every violation at once: field, value, rule.
  std::vector<std::string> problems() const;

  double cosine_exponent() const;  ///< n + 1 of half_power_angle_deg
};

}  // namespace vildar::simulate
