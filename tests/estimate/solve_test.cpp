#include "estimate/solve.h"

#include <cmath>
#include <vector>

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

// Rosenbrock's valley: bent, and a hundred times as steep across as along.
std::optional<Residuals> valley(const Eigen::VectorXd& x, bool with_slopes) {
  Residuals found;
  found.values = Eigen::Vector2d(10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]);
  found.cost = 0.5 * found.values.squaredNorm();
  if (with_slopes) {
    found.slopes.resize(2, 2);
    found.slopes << -20.0 * x[0], -1.0, 10.0, 0.0;  // a column for each residual
  }
  return found;
}

TEST(Descend, FollowsABentValleyToItsEnd) {
  constexpr double kTolerance = 1e-6;
  const auto outcome = descend(valley, Eigen::Vector2d(-1.2, 1.0), kTolerance);
  const Minimum& minimum = std::get<Minimum>(outcome);
  EXPECT_NEAR(minimum.unknowns[0], 1.0, kTolerance);
  // Known to a tenth across the valley and to one along it, where y grows twice as fast as x.
  EXPECT_NEAR(minimum.unknowns[1], 1.0, 2.1 * kTolerance);
  EXPECT_LT(minimum.iterations, 30);
}

TEST(Descend, EndsWhereLargeResidualsBend) {
  // Dennis and Schnabel's example: least at zero, where the cost bends twice as much as
  // its slopes alone say, so that a Gauss-Newton step goes as far beyond as it came from.
  constexpr double kBend = -1.0, kTolerance = 1e-6;
  const auto bent = [](const Eigen::VectorXd& x, bool with_slopes) -> std::optional<Residuals> {
    Residuals found;
    found.values = Eigen::Vector2d(x[0] + 1.0, kBend * x[0] * x[0] + x[0] - 1.0);
    found.cost = 0.5 * found.values.squaredNorm();
    if (with_slopes) {
      found.slopes.resize(1, 2);
      found.slopes << 1.0, 2.0 * kBend * x[0] + 1.0;
    }
    return found;
  };
  const auto outcome = descend(bent, Eigen::VectorXd::Constant(1, 0.1), kTolerance);
  ASSERT_TRUE(std::holds_alternative<Minimum>(outcome));
  const Minimum& minimum = std::get<Minimum>(outcome);
  EXPECT_NEAR(minimum.unknowns[0], 0.0, kTolerance);
  EXPECT_LT(minimum.iterations, 20);
  EXPECT_NEAR(minimum.information(0, 0), 2.0, 1e-5);
}

TEST(Descend, AsksForSlopesOnceAtAPlace) {
  // The same valley with a residual that stays large: steps by the cost's own curvature are refused
  // again and again, which changes nothing of it.
  std::vector<Eigen::Vector2d> asked;
  const auto wide = [&](const Eigen::VectorXd& x, bool with_slopes) {
    auto found = valley(x, with_slopes);
    found->values.conservativeResize(3);
    found->values[2] = 0.3 * x[0] * x[1];
    found->cost = 0.5 * found->values.squaredNorm();
    if (!with_slopes) return found;
    found->slopes.conservativeResize(2, 3);
    found->slopes.col(2) << 0.3 * x[1], 0.3 * x[0];
    asked.emplace_back(x);
    return found;
  };
  const auto outcome = descend(wide, Eigen::Vector2d(-1.2, 1.0), 1e-6);
  ASSERT_TRUE(std::holds_alternative<Minimum>(outcome));
  for (std::size_t i = 0; i < asked.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) EXPECT_NE(asked[i], asked[k]) << k << " and " << i;
}

TEST(Descend, StaysInsideTheDomain) {
  // (ln x)^2 from far off: the full step from 10 leads below zero.
  const auto log_squared = [](const Eigen::VectorXd& x,
                              bool with_slopes) -> std::optional<Residuals> {
    if (!(x[0] > 0.0)) return std::nullopt;
    Residuals found;
    found.values.setConstant(1, std::log(x[0]));
    found.cost = 0.5 * found.values.squaredNorm();
    if (with_slopes) found.slopes.setConstant(1, 1, 1.0 / x[0]);
    return found;
  };
  Eigen::VectorXd start(1);
  start << 10.0;
  const auto outcome = descend(log_squared, start, 1e-6);
  EXPECT_NEAR(std::get<Minimum>(outcome).unknowns[0], 1.0, 1e-6);
  start << -1.0;
  EXPECT_EQ(std::get<Miss>(descend(log_squared, start, 1e-6)), Miss::not_converged);
}

std::optional<Residuals> runaway(const Eigen::VectorXd& x, bool with_slopes) {
  Residuals found;
  found.values.setConstant(1, 1e150 * std::exp(-x[0]));
  found.cost = 0.5 * found.values.squaredNorm();
  if (with_slopes) found.slopes = -found.values.transpose();
  return found;
}

TEST(Descend, GivesNothingWhereNoMinimumIsReached) {
  EXPECT_EQ(std::get<Miss>(descend(runaway, Eigen::VectorXd::Zero(1), 0.0)), Miss::not_converged);
}

TEST(Descend, TakesNoMoreStepsThanItMay) {
  int looks = 0;
  const auto counted = [&](const Eigen::VectorXd& x, bool with_slopes) {
    looks += with_slopes;
    return runaway(x, with_slopes);
  };
  EXPECT_EQ(std::get<Miss>(descend(counted, Eigen::VectorXd::Zero(1), 0.0, {.most_steps = 5})),
            Miss::not_converged);
  EXPECT_EQ(looks, 1 + 5);
}

TEST(Descend, GivesUpWhereItIsHopelessAfterFortySteps) {
  EXPECT_EQ(
      std::get<Miss>(descend(runaway, Eigen::VectorXd::Zero(1), 1e-6, {.hopeless_cost = 1.0})),
      Miss::bad_fit);
  // What gets there sooner is a minimum, however high.
  const auto outcome = descend(valley, Eigen::Vector2d(-1.2, 1.0), 1e-6, {.hopeless_cost = -1.0});
  EXPECT_TRUE(std::holds_alternative<Minimum>(outcome));
}

}  // namespace
}  // namespace vildar
