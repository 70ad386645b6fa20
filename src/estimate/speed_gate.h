#pragma once

#include <algorithm>
#include <cmath>

#include "types/result.h"

namespace vildar {

/// Whether a speed is known well enough to stand by: within 25 % or within 3 m/s, one sigma.
inline bool useful(const SpeedEstimate& speed) {
  constexpr double kShare = 0.25;
  constexpr double kAbsolute_mps = 3.0;
  return speed.std_mps <= kShare * speed.speed_mps || speed.std_mps <= kAbsolute_mps;
}

/// Faster than any vehicle on a road, by more than its sigma.
inline bool too_fast(const SpeedEstimate& speed) {
  constexpr double kFastest_mps = 100.0;
  return speed.speed_mps - speed.std_mps > kFastest_mps;
}

/// Of the logarithm of a speed: from here on the 95 % interval spans a factor of 50, and the speed
/// is none.
inline constexpr double kNoSpeedLogStd = 1.0;

/// No vehicle brakes or speeds up harder.
inline constexpr double kHardestBraking_mps2 = 9.8, kHardestSpeedingUp_mps2 = 5.0;

/// A speed fitted to a part of a track, with the sigma of what the parts do not share.
struct PartSpeed {
  double speed_mps;
  double sigma_mps;
};

/// By how many sigmas of their difference two parts' speeds lie apart. `nested`: one part holds the
/// other, whose data then count in both, so that the variances of two least-squares fits subtract
/// (Hausman 1978, Econometrica 46, 1251-1271, corollary 2.6); no sigma is known so well that less
/// than half the greater variance is left.
inline double sigmas_apart(const PartSpeed& one, const PartSpeed& other, bool nested) {
  const double one_var = one.sigma_mps * one.sigma_mps;
  const double other_var = other.sigma_mps * other.sigma_mps;
  const double most = std::max(one_var, other_var);
  const double difference_var =
      nested ? std::max(std::abs(one_var - other_var), 0.5 * most) : one_var + other_var;
  return std::abs(one.speed_mps - other.speed_mps) / std::sqrt(difference_var);
}

/// Whether two parts cannot tell of one vehicle.
inline bool exclude_each_other(const PartSpeed& one, const PartSpeed& other, bool nested) {
  constexpr double kFar = 3.5;
  return sigmas_apart(one, other, nested) > kFar;
}

}  // namespace vildar
