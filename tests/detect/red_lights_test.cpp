#include "detect/red_lights.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"
#include "detect/detector.h"
#include "optics/response.h"

namespace vildar {
namespace {

constexpr int kWidth_px = 320, kHeight_px = 180;
constexpr double kU_px = 150.3, kV_px = 80.6;

struct Planes {
  std::vector<std::uint8_t> luma, chroma;
};

/// Dark road of code 20 with a noise of 4 codes, and red light that is `share(u, v)` of 26 codes of
/// luma and 42 of Cr; Cb and Cr in planes of their own or interleaved.
Frame red_frame(const std::function<double(double, double)>& share, bool interleaved = false,
                double luma_codes = 26.0, std::uint64_t seed = 1) {
  Random random(seed);
  const auto code = [&](double mean, double sigma) {
    return static_cast<std::uint8_t>(
        std::lround(std::clamp(mean + random.normal(0.0, sigma), 0.0, 255.0)));
  };
  auto planes = std::make_shared<Planes>();
  for (int v = 0; v < kHeight_px; ++v)
    for (int u = 0; u < kWidth_px; ++u)
      planes->luma.push_back(code(20.0 + luma_codes * share(u, v), 4.0));
  constexpr int kColumns = kWidth_px / 2, kRows = kHeight_px / 2;
  const int step = interleaved ? 2 : 1;
  planes->chroma.resize(2 * std::size_t{kColumns} * kRows);
  std::uint8_t* const cb = planes->chroma.data();
  std::uint8_t* const cr = cb + (interleaved ? 1 : kColumns * kRows);
  for (int v = 0; v < kRows; ++v)
    for (int u = 0; u < kColumns; ++u) {
      const double red = share(2.0 * u + 0.5, 2.0 * v + 0.5);
      cb[(v * kColumns + u) * step] = code(128.0 - 14.0 * red, 1.5);
      cr[(v * kColumns + u) * step] = code(128.0 + 42.0 * red, 1.5);
    }
  Frame frame;
  frame.luma.data = planes->luma.data();
  frame.luma.stride_bytes = frame.luma.width_px = kWidth_px;
  frame.luma.height_px = kHeight_px;
  frame.luma.black_code = 16;
  frame.luma.white_code = 235;
  frame.chroma.cb = cb;
  frame.chroma.cr = cr;
  frame.chroma.step_bytes = step;
  frame.chroma.stride_bytes = kColumns * step;
  frame.luma.owner = std::move(planes);
  return frame;
}

std::vector<Blob> blobs_in(const Frame& frame) {
  return Detector({}, Response{}, std::nullopt).detect(frame).blobs;
}

/// A disc 7 px across, its rim a pixel soft.
double disc(double u, double v) {
  return std::clamp(4.0 - std::hypot(u - kU_px, v - kV_px), 0.0, 1.0);
}

TEST(RedLights, ATailLampThatIsHardlyBrighterThanTheNoiseIsFoundByItsColour) {
  for (const bool interleaved : {false, true})
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const std::vector<Blob> blobs = blobs_in(red_frame(disc, interleaved, 26.0, seed));
      ASSERT_EQ(blobs.size(), 1U) << seed;
      EXPECT_EQ(blobs[0].kind, LampKind::taillamp);
      EXPECT_EQ(blobs[0].id, 0);
      EXPECT_NEAR(blobs[0].centre_px.x(), kU_px, 1.0) << seed;
      EXPECT_NEAR(blobs[0].centre_px.y(), kV_px, 1.0) << seed;
    }
}

// The threshold is above the deepest code there.
TEST(RedLights, FramesThatAreBrightAllOverHaveNoLights) {
  for (const int bit_depth : {8, 10}) {
    const auto white = static_cast<std::uint8_t>((1 << bit_depth) - 1);
    std::vector<std::uint8_t> plane(2 * std::size_t{kWidth_px} * kHeight_px, white);
    if (bit_depth > 8)
      for (std::size_t i = 1; i < plane.size(); i += 2) plane[i] = 3;
    for (const bool coloured : {false, true}) {
      Frame frame = red_frame(disc);
      frame.luma.data = plane.data();
      frame.luma.bit_depth = bit_depth;
      frame.luma.stride_bytes = kWidth_px * frame.luma.bytes_per_sample();
      frame.luma.black_code = 0;
      frame.luma.white_code = (1 << bit_depth) - 1;
      if (!coloured) frame.chroma = {};
      EXPECT_TRUE(blobs_in(frame).empty()) << bit_depth;
    }
  }
}

// One lamp of which a column of colour is missing.
TEST(RedLights, ColourThatABreakPartsIsOneLamp) {
  Frame frame = red_frame(disc);
  auto* cr = const_cast<std::uint8_t*>(frame.chroma.cr);
  for (int v = 0; v < kHeight_px / 2; ++v) cr[v * kWidth_px / 2 + 75] = 128;
  EXPECT_EQ(blobs_in(frame).size(), 1U);
}

TEST(RedLights, WhereLumaShowsALampThereIsNoSecondOne) {
  for (const double luma_codes : {48.0, 60.0, 100.0}) {
    const std::vector<Blob> blobs = blobs_in(red_frame(disc, false, luma_codes));
    ASSERT_EQ(blobs.size(), 1U) << luma_codes;
    EXPECT_EQ(blobs[0].kind, LampKind::taillamp);
  }
}

TEST(RedLights, WhatIsDrawnOutOrWideOrGreyOrNoLightIsNone) {
  const auto streak = [](double u, double v) {
    return std::abs(u - kU_px) < 3.0 && std::abs(v - kV_px) < 12.0 ? 1.0 : 0.0;
  };
  EXPECT_TRUE(blobs_in(red_frame(streak)).empty());
  const auto wall = [](double u, double) { return u < 200.0 ? 1.0 : 0.0; };
  EXPECT_TRUE(blobs_in(red_frame(wall)).empty());
  EXPECT_TRUE(blobs_in(red_frame(disc, false, 0.0)).empty()) << "colour without light";
  Frame grey = red_frame(disc);
  grey.chroma = {};
  EXPECT_TRUE(blobs_in(grey).empty());
}

}  // namespace
}  // namespace vildar
