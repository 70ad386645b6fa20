#pragma once

#include <cstdint>
#include <span>

#include "core/outcome.h"
#include "core/quantity.h"
#include "optics/channel.h"

namespace vildar {

struct CurvedAngleFit {
  double speed_mps = 0.0;  ///< V = w r_c, positive: closing
  double angular_speed_rad_per_s = 0.0;
  double angle_at_zero_rad = 0.0;  ///< the paper's beta_o, at t = 0 of the times given
  double speed_sigma_mps = 0.0;    ///< from the scatter about the line alone
  double lag1_correlation = 0.0;   ///< of successive residuals
  std::int64_t samples_used = 0;
  std::int64_t samples_clamped =
      0;  ///< of those used: less power than beta = pi gives, so beta = pi
  std::int64_t samples_outside = 0;  ///< left out: not finite
};

/// Arc angle in (0, pi] whose power K cos^m(beta/2) / (2 r_c sin(beta/2))^gamma is nearest to the
/// one given: the exact inverse, as the law falls steadily with beta; pi for every power below the
/// law's at pi. `power_w` is finite.
double arc_angle_of_power(double power_w, const PowerLaw& law, Metres curve_radius);

/// The paper's curved-road estimator with R_o = d_o = 0: an arc angle per sample, then linear least
/// squares of beta = beta_o - w t and V = w r_c.
/// Misses: too_few_samples, no_time_spread, below_noise (no positive power at all).
/// Throws std::invalid_argument for spans of different length, std::domain_error unless K, gamma
/// and r_c are positive.
Outcome<CurvedAngleFit> fit_curved_angle(std::span<const double> time_s,
                                         std::span<const double> power_w, const PowerLaw& law,
                                         Metres curve_radius);

}  // namespace vildar
