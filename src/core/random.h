#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include "core/quantity.h"

namespace vildar {

/// Seeded random numbers that are the same with every standard library: the generator is the
/// standard's mt19937_64, the distributions are ours.
class Random {
 public:
  explicit Random(std::uint64_t seed) : generator_(seed) {}

  /// Uniform in [0, 1).
  double uniform() { return static_cast<double>(generator_() >> 11) * 0x1.0p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }

  /// Standard normal (Box and Muller).
  double normal() {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    const double angle_rad = 2.0 * kPi * uniform();
    spare_ = radius * std::sin(angle_rad);
    has_spare_ = true;
    return radius * std::cos(angle_rad);
  }
  double normal(double mean, double std) { return mean + std * normal(); }

 private:
  std::mt19937_64 generator_;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

}  // namespace vildar
