#include "detect/peaks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "detect/run_scan.h"

namespace vildar {
namespace {

constexpr int kWidth = 120, kHeight = 80, kThreshold = 20;
constexpr int kMostPixels = 1000;  // of a wide area

/// A hill that falls off by `per_px` codes a pixel from `top`, as one area.
std::vector<std::uint8_t> hill(int top, double per_px) {
  std::vector<std::uint8_t> codes;
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) {
      const double away_px = std::hypot(u - 60.3, v - 39.8);
      codes.push_back(static_cast<std::uint8_t>(std::clamp(top - per_px * away_px, 21.0, 255.0)));
    }
  return codes;
}

/// Pixels of the one light that is found in an area.
int looked_at(const std::vector<std::uint8_t>& codes, const PeakRules& rules) {
  LumaView luma;
  luma.data = codes.data();
  luma.stride_bytes = luma.width_px = kWidth;
  luma.height_px = kHeight;
  std::vector<PixelRun> runs;
  find_runs(luma, kThreshold, runs);
  std::vector<int> all(runs.size());
  std::iota(all.begin(), all.end(), 0);
  PeakFinder finder;
  finder.add(luma, all, runs, kThreshold, rules);
  EXPECT_EQ(finder.peaks().size(), 1u);
  return finder.peaks().empty() ? 0 : finder.peaks().front().area_px;
}

PeakRules rules_for(const std::vector<int>& half_code) {
  PeakRules rules;
  rules.clip_code = 231;
  rules.half_code = half_code;
  return rules;
}

TEST(PeakFinder, OfAWideAreaLooksAtItsBrightestThousandPixels) {
  const std::vector<int> half_code(256, 0);
  for (const double per_px : {0.5, 1.3, 4.0}) {
    const std::vector<std::uint8_t> codes = hill(200, per_px);
    int brightest = 0;
    for (int code = 255; code >= kThreshold; --code) {
      const auto reach =
          std::count_if(codes.begin(), codes.end(), [&](int one) { return one >= code; });
      if (reach > kMostPixels) break;
      brightest = static_cast<int>(reach);
    }
    EXPECT_EQ(looked_at(codes, rules_for(half_code)), brightest) << per_px << " codes a pixel";
  }
}

TEST(PeakFinder, LooksAtAllThatClips) {
  const std::vector<int> half_code(256, 0);
  const std::vector<std::uint8_t> codes = hill(400, 6.0);
  const PeakRules rules = rules_for(half_code);
  const int plateau_code = rules.clip_code - rules.least_valley_codes / 2;
  const auto clip =
      std::count_if(codes.begin(), codes.end(), [&](int one) { return one >= plateau_code; });
  ASSERT_GT(clip, kMostPixels);
  EXPECT_EQ(looked_at(codes, rules), clip);
}

}  // namespace
}  // namespace vildar
