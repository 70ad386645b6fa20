#pragma once

#include <vector>

namespace vildar {

/// Of each value the least among those whose times lie within `reach_s` of its own. `times_s` must
/// increase; as many as values. Linear in their number.
std::vector<double> sliding_minimum(const std::vector<double>& times_s,
                                    const std::vector<double>& values, double reach_s);

/// The same of the greatest.
std::vector<double> sliding_maximum(const std::vector<double>& times_s,
                                    const std::vector<double>& values, double reach_s);

}  // namespace vildar
