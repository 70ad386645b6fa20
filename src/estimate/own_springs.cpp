#include "estimate/own_springs.h"

#include <algorithm>
#include <cmath>

namespace vildar {

bool springs_work(std::span<const EgoDeviation> own_motion) {
  constexpr double kFelt_mps2 = 0.2, kSigmas = 3.0;
  return std::ranges::any_of(own_motion, [&](const EgoDeviation& one) {
    return std::abs(one.springs_mps2) > std::max(kFelt_mps2, kSigmas * one.springs_sigma_mps2);
  });
}

double springs_sigma_rad(const EgoDeviation& own_motion, double per_s) {
  constexpr double kUnlike = 0.15, kAlike_s = 1.0;
  return kUsualSquat.mean *
         std::hypot(kUnlike * own_motion.springs_mps2, own_motion.springs_sigma_mps2) *
         std::sqrt(std::max(1.0, per_s * kAlike_s));
}

}  // namespace vildar
