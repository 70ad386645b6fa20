#pragma once

#include <vector>

namespace vildar {

/// Middle value; the upper one of two. There must be one.
double median(std::vector<double> values);

/// Standard deviation of the normal law about zero of which half the values lie as near to it.
/// There must be one.
double robust_sigma(std::vector<double> values);

}  // namespace vildar
