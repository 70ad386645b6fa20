#pragma once

#include <vector>

#include "types/power.h"

namespace vildar {

/// Means of a trace over consecutive stretches of `block_s`, between `from_s` and `to_s` in
/// photodiode time; `offset_s` turns their times into clip time. A block's time is the mean of its
/// samples'; blocks that hold less than half the samples they should are left out. Sigmas are those
/// of white noise and of rounding.
std::vector<PowerBlock> block_means(const PowerTrace& trace, double from_s, double to_s,
                                    double block_s, double offset_s);

}  // namespace vildar
