#pragma once

#include <cstdint>
#include <span>

#include "core/outcome.h"
#include "core/quantity.h"
#include "optics/channel.h"

namespace vildar {

struct PowerSlopeFit {
  double speed_mps = 0.0;        ///< positive: closing
  double range_at_zero_m = 0.0;  ///< the paper's R_o, at t = 0 of the times given
  double speed_sigma_mps =
      0.0;  ///< from the scatter about the line alone: K, gamma, d taken as exact
  double lag1_correlation =
      0.0;  ///< of successive residuals; far from 0 where the model does not hold
  std::int64_t samples_used = 0;
  /// Left out: power not positive or not finite, or nearer than d (the square root has no value).
  std::int64_t samples_outside = 0;
};

/// The paper's straight-road estimator over the samples given: y = sqrt((P/K)^(-2/gamma) - d^2) and
/// linear least squares of y = -V t + R_o. The law's cosine is not used, as in the paper.
/// Misses: too_few_samples (fewer than three), no_time_spread, below_noise (no positive power at
/// all), outside_model (fewer than three samples lie in the model's domain).
/// Throws std::invalid_argument for spans of different length, std::domain_error unless K > 0,
/// gamma > 0 and d >= 0.
Outcome<PowerSlopeFit> fit_power_slope(std::span<const double> time_s,
                                       std::span<const double> power_w, const PowerLaw& law,
                                       Metres perpendicular);

}  // namespace vildar
