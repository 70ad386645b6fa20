#include "core/robust_line.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace vildar {
namespace {

TEST(RobustLine, IsNotMovedByAMinorityFarOff) {
  std::vector<double> x, y;
  for (int i = -7; i <= 7; ++i) {
    x.push_back(i);
    y.push_back(3.0 - 0.25 * i);
  }
  y[2] += 4.0;
  y[3] += 40.0;
  y[9] -= 5.0;
  y[13] += 7.0;
  const RobustLine line = least_deviations_line(x, y);
  EXPECT_NEAR(line.at_zero, 3.0, 1e-6);
  EXPECT_NEAR(line.slope, -0.25, 1e-6);
  EXPECT_NEAR(line.at(4.0), 2.0, 1e-6);
}

// Of the lines through two of the points one has the least sum of absolute deviations.
TEST(RobustLine, HasTheLeastSumOfDeviations) {
  const std::vector<double> x{0.0, 1.0, 2.0, 3.0, 5.0, 6.0, 8.0};
  const std::vector<double> y{0.3, 1.7, 1.1, 3.9, 4.2, 7.4, 6.8};
  const auto sum_of = [&](double at_zero, double slope) {
    double sum = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) sum += std::abs(y[i] - at_zero - slope * x[i]);
    return sum;
  };
  double least = 1e9;
  for (std::size_t i = 0; i < x.size(); ++i)
    for (std::size_t j = i + 1; j < x.size(); ++j) {
      const double slope = (y[j] - y[i]) / (x[j] - x[i]);
      least = std::min(least, sum_of(y[i] - slope * x[i], slope));
    }
  const RobustLine line = least_deviations_line(x, y);
  EXPECT_LT(sum_of(line.at_zero, line.slope), 1.02 * least);
}

}  // namespace
}  // namespace vildar
