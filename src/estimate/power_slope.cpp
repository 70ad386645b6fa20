#include "estimate/power_slope.h"

#include <cmath>
#include <stdexcept>
#include <vector>

#include "estimate/line_fit.h"
#include "estimate/vector_math.h"

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

  // ln P of the usable samples, then (P/K)^(-2/gamma) - d^2 for all of them at once.
  std::vector<double> used_s, range_m;
  used_s.reserve(time_s.size());
  range_m.reserve(time_s.size());
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    if (!(power_w[i] > 0.0 && std::isfinite(power_w[i]) && std::isfinite(time_s[i]))) continue;
    used_s.push_back(time_s[i]);
    range_m.push_back(power_w[i]);
  }
  const bool any_light = !used_s.empty();
  const double log_gain = std::log(law.gain_w), exponent = -2.0 / law.path_loss_exponent;
  natural_logs(range_m, range_m);
  for (double& value : range_m) value = exponent * (value - log_gain);
  exponentials(range_m, range_m);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < range_m.size(); ++i) {
    const double argument_m2 = range_m[i] - d_m * d_m;
    if (!(argument_m2 >= 0.0) || !std::isfinite(argument_m2)) continue;
    used_s[kept] = used_s[i];
    range_m[kept++] = std::sqrt(argument_m2);
  }
  used_s.resize(kept);
  range_m.resize(kept);
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
