#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "types/power.h"

namespace vildar {

/// Samples [first, first + count).
struct SampleRange {
  std::size_t first = 0;
  std::size_t count = 0;
};

/// Takes ranges out of a trace, which must be in order and must not overlap. Gives the number of
/// samples taken out.
std::int64_t drop_ranges(PowerTrace& trace, const std::vector<SampleRange>& ranges);

}  // namespace vildar
