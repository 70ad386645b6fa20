#include "core/random.h"

#include <gtest/gtest.h>

#include <random>

namespace vildar {
namespace {

TEST(Random, SameSeedSameNumbersOtherSeedOthers) {
  Random a(1), b(1), c(2);
  for (int i = 0; i < 10; ++i) {
    const double value = a.normal();
    EXPECT_EQ(value, b.normal());
    EXPECT_NE(value, c.normal());
  }
}

TEST(Random, UniformIsTheTop53BitsOfTheStandardsGenerator) {
  Random random(99);
  std::mt19937_64 generator(99);
  for (int i = 0; i < 100; ++i)
    EXPECT_EQ(random.uniform(), std::ldexp(static_cast<double>(generator() >> 11), -53));
}

TEST(Random, UniformHasTheMomentsOfItsInterval) {
  constexpr int kTrials = 100'000;
  Random random(3);
  double sum = 0.0, squares = 0.0;
  for (int i = 0; i < kTrials; ++i) {
    const double value = random.uniform(-2.0, 4.0);
    ASSERT_GE(value, -2.0);
    ASSERT_LT(value, 4.0);
    sum += value - 1.0;
    squares += (value - 1.0) * (value - 1.0);
  }
  // Variance w^2 / 12 = 3, fourth moment w^4 / 80 = 16.2; five sigmas of the mean over the trials.
  EXPECT_NEAR(sum / kTrials, 0.0, 5.0 * std::sqrt(3.0 / kTrials));
  EXPECT_NEAR(squares / kTrials, 3.0, 5.0 * std::sqrt((16.2 - 9.0) / kTrials));
}

TEST(Random, NormalHasTheMomentsOfTheBellCurve) {
  constexpr int kTrials = 100'000;
  Random random(4);
  double m1 = 0.0, m2 = 0.0, m3 = 0.0, m4 = 0.0, neighbours = 0.0, before = 0.0;
  for (int i = 0; i < kTrials; ++i) {
    const double z = (random.normal(5.0, 2.0) - 5.0) / 2.0;
    m1 += z / kTrials;
    m2 += z * z / kTrials;
    m3 += z * z * z / kTrials;
    m4 += z * z * z * z / kTrials;
    neighbours += z * before / kTrials;
    before = z;
  }
  // Five sigmas; the variances of z, z^2, z^3, z^4 and of the product of neighbours are 1, 2, 15,
  // 96, 1.
  const double slack = 5.0 / std::sqrt(static_cast<double>(kTrials));
  EXPECT_NEAR(m1, 0.0, slack);
  EXPECT_NEAR(m2, 1.0, slack * std::sqrt(2.0));
  EXPECT_NEAR(m3, 0.0, slack * std::sqrt(15.0));
  EXPECT_NEAR(m4, 3.0, slack * std::sqrt(96.0));
  EXPECT_NEAR(neighbours, 0.0, slack);
}

}  // namespace
}  // namespace vildar
