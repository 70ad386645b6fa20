#include "estimate/power_slope.h"

#include <stdexcept>

#include "estimate/line_fit.h"
#include "estimate/slope_samples.h"

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

  const SlopeSamples used = slope_samples(time_s, power_w, law.gain_w, law.path_loss_exponent, d_m);
  if (used.lit == 0) return Miss::below_noise;
  if (used.time_s.size() < 3) return Miss::outside_model;
  const auto outcome = fit_line(used.time_s, used.along_m);
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
