#pragma once

#include <span>

#include "core/outcome.h"

namespace vildar {

/// Where the squared errors are summed. The two give clearly different numbers from the same data,
/// so a fit must say which it used.
enum class FitDomain {
  decibel,  ///< of 10 log10(P): every distance weighs the same (path loss as it is plotted)
  linear,   ///< of P: the nearest points decide
};

struct PathLossFit {
  double gain_w = 0.0;  ///< K: power at D = 1 m
  double path_loss_exponent = 0.0;
  double rms_db = 0.0;  ///< of 10 log10(P / fit), in either domain
  int iterations = 0;   ///< 0 for the closed form
};

/// Least squares of P = K D^-gamma. Misses: too_few_samples (fewer than two), no_time_spread (all
/// at one distance), below_noise (a power not positive or not finite), not_converged. Throws
/// std::invalid_argument for spans of different length, std::domain_error for a distance that is
/// not positive.
Outcome<PathLossFit> fit_path_loss(std::span<const double> distance_m,
                                   std::span<const double> power_w, FitDomain domain);

}  // namespace vildar
