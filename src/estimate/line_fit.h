#pragma once

#include <cstdint>
#include <span>

#include "core/outcome.h"

namespace vildar {

/// Ordinary least squares of a straight line y = intercept + slope t.
struct LineFit {
  double slope = 0.0;
  double intercept = 0.0;         ///< at t = 0
  double slope_sigma = 0.0;       ///< from the residual scatter, residuals taken as independent
  double residual_sigma = 0.0;    ///< n - 2 degrees of freedom
  double lag1_correlation = 0.0;  ///< of successive residuals
  std::int64_t samples = 0;
};

/// Needs three samples (too_few_samples) at two times or more (no_time_spread). All values finite.
Outcome<LineFit> fit_line(std::span<const double> time_s, std::span<const double> values);

}  // namespace vildar
