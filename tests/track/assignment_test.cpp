#include "track/assignment.h"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

#include "core/random.h"

namespace vildar {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double total_cost(const Eigen::MatrixXd& cost, const std::vector<std::optional<int>>& assigned,
                  double unassigned_cost) {
  double total = 0.0;
  for (int row = 0; row < cost.rows(); ++row)
    total += assigned[row] ? cost(row, *assigned[row]) : unassigned_cost;
  return total;
}

// Least total over every way of giving rows columns or nothing.
double brute_force(const Eigen::MatrixXd& cost, double unassigned_cost, int row, unsigned used) {
  if (row == cost.rows()) return 0.0;
  double best = unassigned_cost + brute_force(cost, unassigned_cost, row + 1, used);
  for (int column = 0; column < cost.cols(); ++column)
    if (!(used >> column & 1U) && cost(row, column) < kInfinity)
      best = std::min(best, cost(row, column) +
                                brute_force(cost, unassigned_cost, row + 1, used | 1U << column));
  return best;
}

TEST(AssignRows, EqualsBruteForceOnEveryShape) {
  Random random(20260301);
  for (int trial = 0; trial < 1500; ++trial) {
    const int rows = static_cast<int>(random.uniform(0.0, 6.0));
    const int columns = static_cast<int>(random.uniform(0.0, 8.0));
    Eigen::MatrixXd cost(rows, columns);
    for (int r = 0; r < rows; ++r)
      for (int c = 0; c < columns; ++c)
        cost(r, c) = random.uniform() < 0.3 ? kInfinity : random.uniform(-3.0, 10.0);
    const double unassigned_cost = random.uniform(-2.0, 12.0);
    const auto assigned = assign_rows(cost, unassigned_cost);
    ASSERT_EQ(static_cast<int>(assigned.size()), rows);
    std::vector<int> uses(columns, 0);
    for (const auto& column : assigned)
      if (column) {
        ASSERT_EQ(++uses[*column], 1);
      }
    EXPECT_NEAR(total_cost(cost, assigned, unassigned_cost),
                brute_force(cost, unassigned_cost, 0, 0U), 1e-9)
        << "trial " << trial;
  }
}

TEST(AssignRows, SevenBySevenWithTies) {
  Random random(20260302);
  for (int trial = 0; trial < 20; ++trial) {
    Eigen::MatrixXd cost(7, 7);
    for (int r = 0; r < 7; ++r)
      for (int c = 0; c < 7; ++c) cost(r, c) = std::floor(random.uniform(0.0, 4.0));
    EXPECT_EQ(total_cost(cost, assign_rows(cost, 100.0), 100.0), brute_force(cost, 100.0, 0, 0U));
  }
}

TEST(AssignRows, RefusesWhatIsNotACost) {
  Eigen::MatrixXd cost = Eigen::MatrixXd::Zero(2, 2);
  EXPECT_THROW(assign_rows(cost, kInfinity), std::invalid_argument);
  cost(1, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(assign_rows(cost, 1.0), std::invalid_argument);
  cost(1, 0) = -kInfinity;
  EXPECT_THROW(assign_rows(cost, 1.0), std::invalid_argument);
}

}  // namespace
}  // namespace vildar
