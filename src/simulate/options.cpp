#include "simulate/options.h"

#include <cmath>

#include "core/text.h"
#include "optics/channel.h"

namespace vildar::simulate {

double Options::cosine_exponent() const {
  return lambertian_order(Radians(radians_from_degrees(half_power_angle_deg))) + 1.0;
}

std::vector<std::string> Options::problems() const {
  std::vector<std::string> found;
  const auto need = [&](bool holds, const char* name, double value, const char* rule) {
    if (!holds)
      found.push_back(std::string(name) + " = " + told_number(value) + ", must be " + rule);
  };
  const auto positive = [&](const char* name, double value) {
    need(value > 0.0 && std::isfinite(value), name, value, "above 0");
  };
  positive("speed", speed_mps);
  positive("start range", start_range_m);
  need(perpendicular_m >= 0.0, "perpendicular distance", perpendicular_m, "0 or above");
  positive("sample period", sample_period_s);
  constexpr double kShortest_s = 1e-6;
  if (sample_period_s > 0.0)
    need(sample_period_s >= kShortest_s, "sample period", sample_period_s, "1e-6 s or more");
  positive("path-loss exponent", path_loss_exponent);
  positive("Lambertian path-loss exponent", lambertian_exponent);
  positive("angular speed", angular_speed_rad_per_s);
  positive("curve radius", curve_radius_m);
  need(curve_start_deg > 0.0 && curve_start_deg < 180.0, "start angle of the curve",
       curve_start_deg, "between 0 and 180");
  need(trials >= 2, "trials", trials, "2 or more");
  need(threads >= 0, "threads", threads, "0 (all) or more");
  need(with_cosine || without_cosine, "cosine", 0.0, "yes, no or both");
  const auto angle = [&](double value) {
    need(value > 0.0 && value < 90.0, "half-power angle", value, "between 0 and 90");
  };
  angle(half_power_angle_deg);
  for (const double value : half_power_angles_deg) angle(value);
  const auto window = [&](double value, double pass_s) {
    need(value >= 3.0 * sample_period_s, "estimation duration", value, "three samples or more");
    need(value < pass_s, "estimation duration", value, "shorter than the pass");
  };
  const double pass_s = start_range_m / speed_mps;
  window(duration_s, pass_s);
  for (const double value : durations_s) window(value, pass_s);
  window(curve_duration_s, radians_from_degrees(curve_start_deg) / angular_speed_rad_per_s);
  for (const double value : speeds_mps) positive("speed", value);
  for (const double value : snrs_db) need(std::isfinite(value), "SNR", value, "finite");
  need(std::isfinite(snr_db), "SNR", snr_db, "finite");
  return found;
}

}  // namespace vildar::simulate
