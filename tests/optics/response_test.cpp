#include "optics/response.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vildar {
namespace {

CameraSite site_with(ResponseKind kind) {
  CameraSite site;
  site.response = kind;
  site.response_exponent = 2.35;
  if (kind == ResponseKind::table)
    for (int code = 0; code < 256; ++code) {
      const double fraction = code / 255.0;
      site.response_table.push_back(0.3 * fraction + 0.7 * fraction * fraction * fraction);
    }
  return site;
}

constexpr ResponseKind kKinds[] = {ResponseKind::linear, ResponseKind::gamma, ResponseKind::srgb,
                                   ResponseKind::bt709, ResponseKind::table};

TEST(Response, InverseUndoesEveryKind) {
  // BT.709 publishes rounded constants, whose branches miss each other at the break:
  // 1.099 * 0.018^0.45 - 0.099 = 0.081248 against 4.5 * 0.018 = 0.081. Inside that gap, a
  // sixteenth of an 8-bit code, no inverse can be exact.
  constexpr double kBreak = 0.081, kGap = 2.49e-4;
  for (const ResponseKind kind : kKinds) {
    const Response response(site_with(kind));
    for (int i = 0; i <= 1000; ++i) {
      const double fraction = i / 1000.0;
      const bool in_gap =
          kind == ResponseKind::bt709 && fraction >= kBreak && fraction <= kBreak + kGap;
      EXPECT_NEAR(response.fraction_from_linear(response.linear_from_fraction(fraction)), fraction,
                  in_gap ? kGap : 1e-12)
          << static_cast<int>(kind) << " at " << fraction;
    }
  }
}

TEST(Response, BlackIsDarkWhiteIsOneAndLightGrowsWithCode) {
  for (const ResponseKind kind : kKinds) {
    const Response response(site_with(kind));
    EXPECT_EQ(response.linear_from_fraction(0.0), 0.0);
    EXPECT_EQ(response.linear_from_fraction(-0.1), 0.0);
    EXPECT_NEAR(response.linear_from_fraction(1.0), 1.0, 1e-12);
    double before = 0.0;
    for (int i = 1; i <= 1000; ++i) {
      const double linear = response.linear_from_fraction(i / 1000.0);
      EXPECT_GT(linear, before) << static_cast<int>(kind);
      before = linear;
    }
  }
}

TEST(Response, KnownPointsOfThePublishedCurves) {
  // sRGB code 188 of 255 is half the light to within a code; BT.709 carries 18 % grey at 0.409.
  const Response srgb;
  EXPECT_NEAR(255.0 * srgb.fraction_from_linear(0.5), 187.52, 0.01);
  EXPECT_NEAR(srgb.linear_from_fraction(0.02), 0.02 / 12.92, 1e-12);
  const Response bt709(site_with(ResponseKind::bt709));
  EXPECT_NEAR(bt709.fraction_from_linear(0.18), 0.4090, 5e-5);
  EXPECT_NEAR(bt709.linear_from_fraction(0.045), 0.01, 1e-12);
}

TEST(Response, TablesServeEveryRangeAndDepth) {
  const Response linear(site_with(ResponseKind::linear));
  LumaView luma;
  luma.bit_depth = 10;
  luma.black_code = 64;
  luma.white_code = 940;
  const std::vector<float> table = linear.table_for(luma);
  ASSERT_EQ(table.size(), 1024u);
  EXPECT_EQ(table[0], 0.0f);
  EXPECT_EQ(table[64], 0.0f);
  EXPECT_FLOAT_EQ(table[502], 0.5f);
  EXPECT_FLOAT_EQ(table[940], 1.0f);
  EXPECT_FLOAT_EQ(table[1023], 959.0f / 876.0f);  // above nominal white the curve goes on
}

}  // namespace
}  // namespace vildar
