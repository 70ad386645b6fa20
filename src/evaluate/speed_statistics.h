#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "evaluate/folders.h"

namespace vildar {

/// A stated speed beside the true one at the same time.
struct SpeedPair {
  StatedSpeed stated;
  double true_mps = 0.0;

  double error_mps() const { return stated.speed_mps - true_mps; }
  /// Absent for a vehicle that stands (below 0.1 m/s), where a percentage has no meaning.
  std::optional<double> error_percent() const;
  /// Error over stated standard deviation; absent where the run states none.
  std::optional<double> z() const;
  /// Absent where the run states no interval.
  std::optional<bool> inside_95() const;
  /// Within 3 km/h up to 100 km/h of true speed, within 3 % above: the limits of type approval.
  bool within_limits() const;
};

/// Of absolute errors, except for the bias, which is the mean of the signed ones (positive: too
/// fast).
struct ErrorSpread {
  std::optional<double> mean_abs, median_abs, p95_abs, max, bias;
};

/// Absent is what no pair has.
struct SpeedStatistics {
  std::size_t count = 0;
  ErrorSpread kmh, percent;
  std::optional<double> share_within_limits;
  std::optional<double> coverage;  ///< share of 95 % intervals that hold the true speed
  std::optional<double> z_rms;
};

SpeedStatistics speed_statistics(std::span<const SpeedPair> pairs);

}  // namespace vildar
