#include "core/assignment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "core/random.h"

namespace vildar {
namespace {

double total(const std::vector<double>& cost, std::size_t columns,
             const std::vector<AssignedPair>& pairs) {
  double sum = 0.0;
  for (const AssignedPair& pair : pairs) sum += cost[pair.row * columns + pair.column];
  return sum;
}

// The least total over all ways to give each row (or each column, where there are fewer) a partner.
double least_total(const std::vector<double>& cost, std::size_t rows, std::size_t columns) {
  std::vector<std::size_t> order(std::max(rows, columns));
  std::iota(order.begin(), order.end(), std::size_t{0});
  double least = std::numeric_limits<double>::infinity();
  do {
    double sum = 0.0;
    for (std::size_t i = 0; i < std::min(rows, columns); ++i)
      sum += rows <= columns ? cost[i * columns + order[i]] : cost[order[i] * columns + i];
    least = std::min(least, sum);
  } while (std::ranges::next_permutation(order).found);
  return least;
}

void expect_one_to_one(const std::vector<AssignedPair>& pairs, std::size_t rows,
                       std::size_t columns) {
  ASSERT_EQ(pairs.size(), std::min(rows, columns));
  std::vector<int> row_used(rows, 0), column_used(columns, 0);
  for (const AssignedPair& pair : pairs) {
    ASSERT_LT(pair.row, rows);
    ASSERT_LT(pair.column, columns);
    EXPECT_EQ(++row_used[pair.row], 1);
    EXPECT_EQ(++column_used[pair.column], 1);
  }
  EXPECT_TRUE(std::ranges::is_sorted(pairs, {}, &AssignedPair::row));
}

TEST(Assignment, IsAsCheapAsTheBestOfAllPermutations) {
  constexpr double kSums = 1e-12;  // a few additions of numbers up to 10
  Random random(20260301);
  for (std::size_t rows = 1; rows <= 6; ++rows)
    for (std::size_t columns = 1; columns <= 6; ++columns)
      for (int trial = 0; trial < 12; ++trial) {
        std::vector<double> cost(rows * columns);
        for (double& value : cost) value = random.uniform(-10.0, 10.0);
        if (trial % 3 == 0)  // ties
          for (double& value : cost) value = std::round(value / 5.0);
        const auto pairs = assign(cost, rows, columns);
        expect_one_to_one(pairs, rows, columns);
        EXPECT_NEAR(total(cost, columns, pairs), least_total(cost, rows, columns), kSums)
            << rows << " x " << columns;
      }
}

TEST(Assignment, FindsAPlantedOptimumAmongMany) {
  // cost = u_i + v_j + slack, slack zero on the planted pairs and positive elsewhere: linear
  // programming duality makes the planted assignment the only best one.
  constexpr std::size_t kRows = 40, kColumns = 40;
  Random random(7);
  std::vector<std::size_t> partner(kRows);
  std::iota(partner.begin(), partner.end(), std::size_t{0});
  for (std::size_t i = kRows; i-- > 1;)
    std::swap(partner[i], partner[static_cast<std::size_t>(random.uniform() * double(i + 1))]);
  std::vector<double> row_price(kRows), column_price(kColumns), cost(kRows * kColumns);
  for (double& value : row_price) value = random.uniform(-50.0, 50.0);
  for (double& value : column_price) value = random.uniform(-50.0, 50.0);
  for (std::size_t i = 0; i < kRows; ++i)
    for (std::size_t j = 0; j < kColumns; ++j)
      cost[i * kColumns + j] =
          row_price[i] + column_price[j] + (partner[i] == j ? 0.0 : random.uniform(0.01, 5.0));
  const auto pairs = assign(cost, kRows, kColumns);
  expect_one_to_one(pairs, kRows, kColumns);
  for (const AssignedPair& pair : pairs) EXPECT_EQ(pair.column, partner[pair.row]);
}

TEST(Assignment, NothingToAssignGivesNoPairs) {
  EXPECT_TRUE(assign({}, 0, 0).empty());
  EXPECT_TRUE(assign({}, 0, 5).empty());
  EXPECT_TRUE(assign({}, 5, 0).empty());
}

TEST(Assignment, RefusesAWrongSizeAndCostsThatAreNotFinite) {
  const std::vector<double> cost{1.0, 2.0, 3.0, std::numeric_limits<double>::infinity()};
  EXPECT_THROW(assign(cost, 3, 2), std::invalid_argument);
  EXPECT_THROW(assign(cost, 2, 2), std::invalid_argument);
}

}  // namespace
}  // namespace vildar
