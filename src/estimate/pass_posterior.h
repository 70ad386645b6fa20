#pragma once

#include "core/outcome.h"
#include "estimate/power_method.h"

namespace vildar {

/// What the light of one pass tells of all that shapes it (PassLight), the lamps' likeness to the
/// law included: ways from 0.01 to 1 nat, besides 0.15 of what the site leaves open of ln K, are
/// weighed by their evidence and the inverse root of their size.
struct PassPosterior {
  PassMotion motion;           ///< mean
  double log_speed_std = 0.0;  ///< of ln of its speed
  double ripple_nat = 0.0;     ///< root mean square, as in beam_shape_std
  /// More likely than not the lamps are unlike the law by 0.1 nat or more. What the fit does not
  /// know of the law it then trades for motion, by more than the sigma says.
  bool unlike_the_law = false;
  double background_w = 0.0;  ///< to be taken off the series, mean
  double background_std_w = 0.0;
  double chi2_per_dof = 0.0;  ///< of the likeliest
  double prior_chi2 = 0.0;    ///< of its acceleration, exponent, lengths, gain and background
};

/// `start` is where the fits begin; where the background is unsure they begin at several of its
/// values, each from what the paper's estimator then makes of the light. Misses: bad_fit where a
/// fit was given up as hopeless and none converged, outside_model where none converged otherwise or
/// there are fewer than five blocks.
Outcome<PassPosterior> pass_posterior(const PowerSeries& series, const PowerCase& known,
                                      const PassMotion& start);

/// The same from what the paper's estimator makes of the light, else from the likeliest motion
/// under the law.
Outcome<PassPosterior> pass_posterior(const PowerSeries& series, const PowerCase& known);

}  // namespace vildar
