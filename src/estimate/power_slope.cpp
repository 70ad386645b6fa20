#include "estimate/power_slope.h"

#include <cmath>
#include <stdexcept>
#include <vector>

#include "estimate/line_fit.h"

namespace vildar {

Outcome<PowerSlopeFit> fit_power_slope(std::span<const double> time_s,
                                       std::span<const double> power_w, const PowerLaw& law,
                                       Metres perpendicular) {
  if (time_s.size() != power_w.size())
    throw std::invalid_argument("fit_power_slope: as many times as powers are needed");
  const double d_m = perpendicular.value();
  if (!(law.gain_w > 0.0 && law.path_loss_exponent > 0.0 && d_m >= 0.0))
    throw std::domain_error("fit_power_slope: K and gamma must be positive, d not negative");
  if (time_s.size() < 3) return Miss::too_few_samples;

  std::vector<double> used_s, range_m;
  used_s.reserve(time_s.size());
  range_m.reserve(time_s.size());
  bool any_light = false;
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    if (!(power_w[i] > 0.0 && std::isfinite(power_w[i]) && std::isfinite(time_s[i]))) continue;
    any_light = true;
    const double distance2_m2 = std::pow(power_w[i] / law.gain_w, -2.0 / law.path_loss_exponent);
    const double argument_m2 = distance2_m2 - d_m * d_m;
    if (!(argument_m2 >= 0.0) || !std::isfinite(argument_m2)) continue;
    used_s.push_back(time_s[i]);
    range_m.push_back(std::sqrt(argument_m2));
  }
  if (!any_light) return Miss::below_noise;
  if (used_s.size() < 3) return Miss::outside_model;
  const auto outcome = fit_line(used_s, range_m);
  if (const Miss* miss = std::get_if<Miss>(&outcome)) return *miss;
  const LineFit& line = std::get<LineFit>(outcome);
  PowerSlopeFit fit;
  fit.speed_mps = -line.slope;
  fit.range_at_zero_m = line.intercept;
  fit.speed_sigma_mps = line.slope_sigma;
  fit.lag1_correlation = line.lag1_correlation;
  fit.samples_used = line.samples;
  fit.samples_outside = static_cast<std::int64_t>(time_s.size()) - line.samples;
  return fit;
}

}  // namespace vildar
