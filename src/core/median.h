#pragma once

#include <vector>

namespace vildar {

/// Middle value; the upper one of two. There must be one.
double median(std::vector<double> values);

}  // namespace vildar
