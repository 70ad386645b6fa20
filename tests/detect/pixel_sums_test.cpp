#include "detect/pixel_sums.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"
#include "detect/residual_shape.h"

namespace vildar {
namespace {

constexpr std::size_t kPixels = 160, kRows = 6;
constexpr double kSingle = 1e-5;  // of sums of some hundred numbers near 1 in single precision

std::vector<float> numbers(Random& random, double from, double to) {
  std::vector<float> all(kPixels);
  for (float& one : all) one = static_cast<float>(random.uniform(from, to));
  return all;
}

TEST(PixelSums, AreThoseOfPlainLoops) {
  Random random(40);
  std::vector<std::vector<float>> data;
  for (std::size_t i = 0; i < kRows; ++i) data.push_back(numbers(random, -1.0, 1.0));
  const std::vector<PixelRow> rows(data.begin(), data.end());
  const std::vector<float> weight = numbers(random, 0.0, 2.0);
  const std::vector<float> factors{0.5F, -2.0F, 3.0F, 0.0F, 1.0F, 7.0F};
  const std::vector<float> base = numbers(random, -1.0, 1.0);
  std::vector<float> sum(kPixels), on_base(kPixels);
  set_rows(rows, factors, {}, sum);
  set_rows(rows, factors, base, on_base);
  for (std::size_t k = 0; k < kPixels; ++k) {
    double plain = 0.0;
    for (std::size_t i = 0; i < kRows; ++i)
      plain += static_cast<double>(factors[i]) * static_cast<double>(data[i][k]);
    EXPECT_NEAR(sum[k], plain, kSingle);
    EXPECT_NEAR(on_base[k], plain + static_cast<double>(base[k]), kSingle);
  }
  std::vector<double> products(kRows), squares(kRows * (kRows + 1) / 2);
  sum_products(rows, weight, products);
  sum_squares(rows, weight, squares);
  std::size_t at = 0;
  for (std::size_t i = 0; i < kRows; ++i) {
    double product = 0.0;
    for (std::size_t k = 0; k < kPixels; ++k)
      product += static_cast<double>(data[i][k]) * static_cast<double>(weight[k]);
    EXPECT_NEAR(products[i], product, kPixels * kSingle);
    for (std::size_t j = 0; j <= i; ++j, ++at) {
      double square = 0.0;
      for (std::size_t k = 0; k < kPixels; ++k)
        square += static_cast<double>(data[i][k]) * static_cast<double>(data[j][k]) *
                  static_cast<double>(weight[k]);
      EXPECT_NEAR(squares[at], square, kPixels * kSingle) << i << " " << j;
    }
  }
}

TEST(PixelSums, FormsAreThoseOfThePlainTriangle) {
  Random random(42);
  std::vector<std::vector<float>> data;
  for (std::size_t i = 0; i < kRows; ++i) data.push_back(numbers(random, -1.0, 1.0));
  const std::vector<PixelRow> rows(data.begin(), data.end());
  std::vector<float> root;
  while (root.size() < kRows * (kRows + 1) / 2)
    root.push_back(static_cast<float>(random.uniform(-1.0, 1.0)));
  std::vector<float> forms(kPixels);
  set_forms(rows, root, forms);
  for (std::size_t k = 0; k < kPixels; ++k) {
    double plain = 0.0;
    std::size_t at = 0;
    for (std::size_t i = 0; i < kRows; ++i) {
      double along = 0.0;
      for (std::size_t j = i; j < kRows; ++j, ++at)
        along += static_cast<double>(root[at]) * static_cast<double>(data[j][k]);
      plain += along * along;
    }
    EXPECT_NEAR(forms[k], plain, kRows * kSingle);
  }
}

TEST(PixelSums, PlacesAreThoseOfTheLampFurthestInWhoseRingsAPixelLies) {
  Random random(43);
  const std::vector<float> u_px = numbers(random, -20.0, 20.0);
  const std::vector<float> v_px = numbers(random, -20.0, 20.0);
  std::vector<float> keep(kPixels, 0.04F);
  keep[5] = keep[kPixels - 1] = 0.0F;
  const std::vector<LampRings> lamps{{-8.2F, 1.1F, 3.0F, 0.4F}, {9.3F, -2.4F, 0.0F, 0.3F}};
  std::vector<std::int32_t> places(kPixels);
  set_places(u_px, v_px, keep, lamps, places);
  int compared = 0;
  for (std::size_t k = 0; k < kPixels; ++k) {
    if (keep[k] == 0.0F) {
      EXPECT_EQ(places[k], 2 * ResidualShape::kRings * ResidualShape::kQuarters);
      continue;
    }
    int nearest = 0;
    float rings[2] = {};
    for (int i = 0; i < 2; ++i) {
      const LampRings& lamp = lamps[static_cast<std::size_t>(i)];
      const float away_px = std::hypot(u_px[k] - lamp.u_px, v_px[k] - lamp.v_px);
      rings[i] = std::max(away_px - lamp.inner_px, 0.0F) * lamp.per_px;
      if (rings[i] <= rings[nearest]) nearest = i;
    }
    // Rounding may part what lies between two rings.
    if (std::abs(rings[nearest] - std::round(rings[nearest])) < kSingle && rings[nearest] > 0.0F)
      continue;
    ++compared;
    const LampRings& lamp = lamps[static_cast<std::size_t>(nearest)];
    EXPECT_EQ(places[k], ResidualShape::place_of(
                             nearest, {u_px[k] - lamp.u_px, v_px[k] - lamp.v_px}, rings[nearest]));
  }
  EXPECT_GT(compared, static_cast<int>(kPixels) / 2);
}

TEST(PixelSums, WeightsAreThoseOfTheModelsLight) {
  Random random(41);
  const std::vector<float> rounding{1e-6F, 4e-6F, 9e-6F};
  PixelNoise noise;
  noise.dark_variance = 1e-5;
  noise.electrons = 5000.0;
  noise.rounding = rounding;
  constexpr double kPatchVariance = 0.16;
  const std::vector<float> light = numbers(random, -0.1, 1.0);
  const std::vector<float> expected = numbers(random, -0.2, 1.5);
  const std::vector<float> backdrop = numbers(random, -0.1, 0.2);
  const std::vector<float> before = numbers(random, 0.0, 100.0);
  std::vector<float> keep(kPixels, 1.0F);
  keep[3] = keep[kPixels - 1] = 0.0F;
  std::vector<float> residual(kPixels), weight(kPixels), pull(kPixels), noise_share(kPixels);
  const WeighedCosts costs =
      weigh({light, keep, expected, backdrop, before, residual, weight, pull, noise_share}, noise,
            kPatchVariance);
  double own = 0.0, frozen = 0.0;
  for (std::size_t k = 0; k < kPixels; ++k) {
    const double of_light = noise.variance(static_cast<double>(expected[k]));
    const double uneven = std::max(static_cast<double>(backdrop[k]), 0.0);
    const double variance = of_light + kPatchVariance * uneven * uneven;
    const double off = static_cast<double>(light[k]) - static_cast<double>(expected[k]);
    const double here = static_cast<double>(keep[k]) / variance;
    EXPECT_NEAR(residual[k], off, kSingle);
    EXPECT_NEAR(weight[k], here, kSingle * here);
    EXPECT_NEAR(pull[k], off * here, kSingle * here);
    EXPECT_NEAR(noise_share[k], of_light / variance, kSingle);
    own += off * off * here;
    frozen += off * off * static_cast<double>(before[k]);
  }
  EXPECT_NEAR(costs.own, own, kSingle * own);
  EXPECT_NEAR(costs.frozen, frozen, kSingle * frozen);
}

}  // namespace
}  // namespace vildar
