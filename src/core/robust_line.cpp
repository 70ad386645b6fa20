#include "core/robust_line.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/median.h"

namespace vildar {

RobustLine least_deviations_line(std::span<const double> x, std::span<const double> y) {
  // Least squares, again and again, each point weighted by how near it came.
  constexpr int kRounds = 15;
  constexpr double kNear = 0.1;  // of the typical deviation; nearer counts as so near
  RobustLine line{median({y.begin(), y.end()}), 0.0};
  std::vector<double> off(x.size());
  for (int round = 0; round < kRounds; ++round) {
    for (std::size_t i = 0; i < x.size(); ++i) off[i] = std::abs(y[i] - line.at(x[i]));
    const double nearest = kNear * median(off);
    double w = 0.0, wx = 0.0, wy = 0.0, wxx = 0.0, wxy = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      const double weight = 1.0 / std::max({off[i], nearest, 1e-12});
      w += weight;
      wx += weight * x[i];
      wy += weight * y[i];
      wxx += weight * x[i] * x[i];
      wxy += weight * x[i] * y[i];
    }
    line.slope = (w * wxy - wx * wy) / (w * wxx - wx * wx);
    line.at_zero = (wy - line.slope * wx) / w;
  }
  return line;
}

}  // namespace vildar
