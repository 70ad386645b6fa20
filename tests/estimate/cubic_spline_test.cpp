#include "estimate/cubic_spline.h"

#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

namespace vildar {
namespace {

const std::vector<double> kBreaks{-1.0, 0.2, 0.5, 2.0, 2.1, 4.0};

TEST(CubicSpline, ValuesSumToOneAndSlopesToNothing) {
  const CubicSpline spline(kBreaks);
  EXPECT_EQ(spline.size(), static_cast<int>(kBreaks.size()) + 2);
  for (double u = -1.3; u < 4.3; u += 0.07) {
    const auto local = spline.at(u);
    double value = 0.0, slope = 0.0;
    for (std::size_t k = 0; k < 4; ++k) {
      value += local.value[k];
      slope += local.slope[k];
    }
    EXPECT_NEAR(value, 1.0, 1e-12) << u;
    EXPECT_NEAR(slope, 0.0, 1e-10) << u;
  }
}

// The coefficients of a cubic are its blossom at three neighbouring knots.
TEST(CubicSpline, HoldsAnyCubicExactly) {
  const CubicSpline spline(kBreaks);
  std::vector<double> knots(3, kBreaks.front());
  knots.insert(knots.end(), kBreaks.begin(), kBreaks.end());
  knots.insert(knots.end(), 3, kBreaks.back());
  for (double u = -1.0; u < 4.0; u += 0.11) {
    const auto local = spline.at(u);
    double value = 0.0, slope = 0.0;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t i = static_cast<std::size_t>(local.first) + k;
      const double cubic = knots[i + 1] * knots[i + 2] * knots[i + 3];
      value += local.value[k] * cubic;
      slope += local.slope[k] * cubic;
    }
    EXPECT_NEAR(value, u * u * u, 1e-10);
    EXPECT_NEAR(slope, 3.0 * u * u, 1e-9);
  }
}

TEST(CubicSpline, RefusesBreaksThatDoNotIncrease) {
  EXPECT_THROW(CubicSpline({1.0}), std::invalid_argument);
  EXPECT_THROW(CubicSpline({1.0, 1.0, 2.0}), std::invalid_argument);
}

}  // namespace
}  // namespace vildar
