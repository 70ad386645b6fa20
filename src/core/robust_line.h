#pragma once

#include <span>

namespace vildar {

/// y = at_zero + slope x.
struct RobustLine {
  double at_zero = 0.0, slope = 0.0;
  double at(double x) const { return at_zero + slope * x; }
};

/// Line of least absolute deviations, which a minority of points far off does not move. `x` and `y`
/// are of one length, two at least, and `x` not all the same.
RobustLine least_deviations_line(std::span<const double> x, std::span<const double> y);

}  // namespace vildar
