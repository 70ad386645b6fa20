#include "estimate/solve.h"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

namespace vildar {
namespace {

// Falls for ever: every step gains, none ends.
struct Runaway {
  template <class T>
  bool operator()(const T* x, T* residual) const {
    using std::exp;
    residual[0] = 1e90 * exp(-x[0]);
    return true;
  }
};

struct Line {
  template <class T>
  bool operator()(const T* x, T* residual) const {
    residual[0] = (x[0] - 3.0) / 0.5;
    return true;
  }
};

template <class Cost>
Outcome<Solution> solved(double& x) {
  ceres::Problem problem;
  problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Cost, 1, 1>(new Cost), nullptr, &x);
  return solve(problem, {&x});
}

TEST(Solve, GivesNothingWhereNoMinimumIsReached) {
  double x = 0.0;
  EXPECT_EQ(std::get<Miss>(solved<Runaway>(x)), Miss::not_converged);
}

TEST(Solve, CovarianceIsTheInverseOfTheInformation) {
  double x = 0.0;
  const auto outcome = solved<Line>(x);
  EXPECT_NEAR(x, 3.0, 1e-9);
  EXPECT_NEAR(std::get<Solution>(outcome).covariance(0, 0), 0.25, 1e-12);
}

}  // namespace
}  // namespace vildar
