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

/// The lights found in an area of this width that fills the picture.
std::vector<Peak> peaks_in(const std::vector<std::uint8_t>& codes, const PeakRules& rules,
                           int width_px = kWidth) {
  LumaView luma;
  luma.data = codes.data();
  luma.stride_bytes = luma.width_px = width_px;
  luma.height_px = static_cast<int>(codes.size()) / width_px;
  std::vector<PixelRun> runs;
  find_runs(luma, kThreshold, runs);
  std::vector<int> all(runs.size());
  std::iota(all.begin(), all.end(), 0);
  PeakFinder finder;
  finder.add(luma, all, runs, kThreshold, rules);
  return finder.peaks();
}

/// Pixels of the one light that is found in an area.
int looked_at(const std::vector<std::uint8_t>& codes, const PeakRules& rules) {
  const std::vector<Peak> peaks = peaks_in(codes, rules);
  EXPECT_EQ(peaks.size(), 1u);
  return peaks.empty() ? 0 : peaks.front().area_px;
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

TEST(PeakFinder, AFlatDiscIsOneLightHoweverLarge) {
  const std::vector<int> half_code(256, 0);
  for (const int flat : {60, 110}) {
    std::vector<std::uint8_t> codes = hill(200, 4.0);
    for (std::uint8_t& code : codes) code = std::min(code, static_cast<std::uint8_t>(flat));
    const auto top = std::count(codes.begin(), codes.end(), flat);
    ASSERT_GT(top, kMostPixels);
    EXPECT_EQ(looked_at(codes, rules_for(half_code)), top) << flat;
  }
}

TEST(PeakFinder, AFlatAreaLargerThanAnyLampIsNone) {
  const std::vector<int> half_code(256, 0);
  for (const std::uint8_t code : {std::uint8_t{100}, std::uint8_t{220}})
    EXPECT_TRUE(
        peaks_in(std::vector<std::uint8_t>(400 * 200, code), rules_for(half_code), 400).empty());
}

}  // namespace
}  // namespace vildar
