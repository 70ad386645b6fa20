#pragma once

#include <array>
#include <vector>

namespace vildar {

/// Cubic B-splines over increasing break points, clamped at both ends: any smooth curve is a sum of
/// size() of them. Outside the break points the end pieces go on.
class CubicSpline {
 public:
  /// Throws std::invalid_argument for fewer than two breaks or breaks that do not increase.
  explicit CubicSpline(const std::vector<double>& breaks);

  int size() const { return static_cast<int>(knots_.size()) - 4; }

  /// The four splines that are not zero at `u`: the first one's number, values and slopes.
  struct Local {
    int first = 0;
    std::array<double, 4> value{}, slope{};
  };
  Local at(double u) const;

 private:
  std::vector<double> knots_;
};

}  // namespace vildar
