#pragma once

#include <cmath>

#include "core/quantity.h"

namespace vildar {

/// -2 ln of the normal distribution function, its first and its second derivative over 2.
struct Censored {
  double cost, slope, curve;
  explicit Censored(double z) {
    if (z > 6.0) {
      cost = slope = curve = 0.0;
      return;
    }
    // Mills' ratio by its continued fraction where the function underflows.
    double hazard;
    if (z > -6.0) {
      const double below = 0.5 * std::erfc(-z * std::sqrt(0.5));
      hazard = std::exp(-0.5 * z * z) / std::sqrt(2.0 * kPi) / below;
      cost = -2.0 * std::log(below);
    } else {
      const double x = -z;
      hazard = x + 1.0 / (x + 2.0 / (x + 3.0 / (x + 4.0 / x)));
      cost = z * z + 2.0 * std::log(hazard * std::sqrt(2.0 * kPi));
    }
    slope = hazard;
    curve = hazard * (hazard + z);
  }
};

}  // namespace vildar
