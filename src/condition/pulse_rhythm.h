#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "types/power.h"

namespace vildar {

/// Consecutive samples of a trace.
struct PulseWindow {
  double low_w = 0.0, high_w = 0.0;  ///< of some of them, that are in step with nothing
  bool whole = false;                ///< no sample is missing
  bool clear = false;                ///< jumps up and down by far more than noise
  bool told = false;  ///< by more than enough to tell of each sample which level it is at

  double jump_w() const { return high_w - low_w; }
  double share(double power_w) const { return (power_w - low_w) / jump_w(); }
};

/// All of a trace but what is left over at its end, in windows of 25 ms.
struct PulseWindows {
  std::vector<PulseWindow> each;
  std::size_t samples = 0;  ///< of each

  const PulseWindow* at(std::size_t sample) const {
    return sample / samples < each.size() ? &each[sample / samples] : nullptr;
  }
  /// From trough to crest of the waves, as of mains flicker, in windows that do not jump; 0 where
  /// those hold noise and slow changes alone.
  double waves_w(const PowerTrace& trace) const;
};

PulseWindows pulse_windows(const PowerTrace& trace);

/// Lamps are on from `on_s` + k periods for `duty` of each.
struct PulseRhythm {
  double on_s = 0.0, period_s = 0.0, duty = 0.0;

  double periods_at(double time_s) const { return (time_s - on_s) / period_s; }
  /// Within a period, 0 to 1.
  static double phase_of(double periods) { return periods - std::floor(periods); }
};

/// What is of one vehicle.
struct PulseStretch {
  PulseRhythm rhythm;
  double from_s = 0.0, to_s = 0.0;  ///< where its edges were seen
};

/// Times at which light goes through the middle between its two levels.
struct PulseEdges {
  std::vector<double> up_s, down_s;
};

/// Of windows [first, end).
PulseEdges pulse_edges(const PowerTrace& trace, const PulseWindows& windows, std::size_t first,
                       std::size_t end);

/// From the edges about `middle_s` as far as edges keep to one line against their numbers.
std::optional<PulseStretch> stretch_about(double middle_s, std::span<const double> up_s,
                                          std::span<const double> down_s, double sample_s);

}  // namespace vildar
