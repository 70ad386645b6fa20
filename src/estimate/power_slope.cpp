#include "estimate/power_slope.h"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include <Eigen/Core>

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

  // ln P of the usable samples, then (P/K)^(-2/gamma) - d^2 for all of them at once. Every sample
  // is written, and the next one over it where it is of no use: no branch that noise could
  // mispredict.
  const std::size_t samples = time_s.size();
  std::vector<double> used_s(samples), range_m(samples);
  constexpr double kMost = std::numeric_limits<double>::max();
  std::size_t lit = 0;
  for (std::size_t i = 0; i < samples; ++i) {
    used_s[lit] = time_s[i];
    range_m[lit] = power_w[i];
    lit += (power_w[i] > 0.0) & (power_w[i] <= kMost) & (std::abs(time_s[i]) <= kMost);
  }
  if (lit == 0) return Miss::below_noise;
  const double log_gain = std::log(law.gain_w), exponent = -2.0 / law.path_loss_exponent;
  const std::span<double> values(range_m.data(), lit);
  Eigen::Map<Eigen::ArrayXd> array(range_m.data(), static_cast<Eigen::Index>(lit));
  natural_logs(values, values);
  array = exponent * (array - log_gain);
  exponentials(values, values);
  array = (array - d_m * d_m).max(-1.0).sqrt();  // NaN where there is none
  std::size_t kept = 0;
  for (std::size_t i = 0; i < lit; ++i) {
    const double along_m = range_m[i];
    used_s[kept] = used_s[i];
    range_m[kept] = along_m;
    kept += along_m <= kMost;
  }
  used_s.resize(kept);
  range_m.resize(kept);
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
