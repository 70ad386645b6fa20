#include "core/text.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>

namespace vildar {
namespace {

TEST(NumberText, EveryFiniteDoubleComesBack) {
  std::mt19937_64 bits(5);
  int finite = 0;
  for (int trial = 0; trial < 20'000; ++trial) {
    const double value = std::bit_cast<double>(bits());
    if (!std::isfinite(value)) continue;
    ++finite;
    EXPECT_EQ(std::strtod(number_text(value).c_str(), nullptr), value);
  }
  EXPECT_GT(finite, 19'000);
}

TEST(NumberText, IsShortAndEmptyWhereNotFinite) {
  EXPECT_EQ(number_text(0.1), "0.1");
  EXPECT_EQ(number_text(-12.0), "-12");
  EXPECT_EQ(number_text(std::nan("")), "");
  EXPECT_EQ(number_text(std::numeric_limits<double>::infinity()), "");
}

TEST(FixedText, KeepsTheDigitsAskedFor) {
  EXPECT_EQ(fixed_text(1.25, 3), "1.250");
  EXPECT_EQ(fixed_text(-0.0625, 2), "-0.06");
  EXPECT_EQ(fixed_text(1e300, 1).size(), 303u);
  EXPECT_EQ(fixed_text(-std::numeric_limits<double>::infinity(), 1), "");
}

TEST(NearestName, FindsSlipsOfTheKeyboardAndNothingFarOff) {
  constexpr std::array<std::string_view, 4> kNames{"focal_px", "area_m2", "turn", "position_m"};
  EXPECT_EQ(nearest_name("focal_pix", kNames), "focal_px");
  EXPECT_EQ(nearest_name("aera_m2", kNames), "area_m2");
  EXPECT_EQ(nearest_name("positon_m", kNames), "position_m");
  EXPECT_EQ(nearest_name("turn", kNames), "turn");
  EXPECT_EQ(nearest_name("wavelength_nm", kNames), "");
  EXPECT_EQ(nearest_name("turn", {}), "");
}

}  // namespace
}  // namespace vildar
