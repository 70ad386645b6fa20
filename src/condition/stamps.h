#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "types/power.h"

namespace vildar {

/// Samples that a block of this length has where none is missing; block_s positive.
inline std::ptrdiff_t usual_samples(const PowerTrace& trace, double block_s) {
  constexpr double kMost = 1e9;
  return static_cast<std::ptrdiff_t>(
      std::min(kMost, block_s / std::max(trace.sample_period_s, 1e-12)));
}

/// As std::lower_bound over increasing stamps, but looks about `usual` samples ahead first.
inline std::vector<double>::const_iterator first_not_before(
    std::vector<double>::const_iterator from, std::vector<double>::const_iterator end,
    double time_s, std::ptrdiff_t usual) {
  constexpr std::ptrdiff_t kAbout = 4;
  if (usual > kAbout && end - from > usual + kAbout && from[usual - kAbout] < time_s &&
      !(from[usual + kAbout] < time_s))
    return std::lower_bound(from + usual - kAbout, from + usual + kAbout, time_s);
  return std::lower_bound(from, end, time_s);
}

}  // namespace vildar
