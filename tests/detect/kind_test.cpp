#include "detect/kind.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/random.h"
#include "optics/lamp_colour.h"
#include "optics/picture.h"

namespace vildar {
namespace {

// Chroma of either depth, planar or interleaved, against the mean of its fractions pixel by pixel.
TEST(RimColour, IsTheMeanOfTheRimsPixels) {
  constexpr int kWidth = 40, kHeight = 30, kLevel = 60, kClip = 200;
  constexpr double kRounding = 1e-15;
  Random random(8);
  for (const int chroma_bits : {8, 10})
    for (const int step : {1, 2}) {
      std::vector<std::uint8_t> luma(kWidth * kHeight);
      for (std::uint8_t& code : luma) code = static_cast<std::uint8_t>(random.uniform(0.0, 255.0));
      const int bytes = chroma_bits > 8 ? 2 : 1;
      std::vector<std::uint8_t> cb(kWidth * kHeight), cr(cb.size());
      for (std::size_t i = 0; i < cb.size(); ++i) {
        const double most = bytes == 2 && i % 2 == 1 ? 4.0 : 256.0;  // of a high byte
        cb[i] = static_cast<std::uint8_t>(random.uniform(0.0, most));
        cr[i] = static_cast<std::uint8_t>(random.uniform(0.0, most));
      }
      Frame frame;
      frame.luma.data = luma.data();
      frame.luma.stride_bytes = frame.luma.width_px = kWidth;
      frame.luma.height_px = kHeight;
      frame.chroma.cb = cb.data();
      frame.chroma.cr = cr.data();
      frame.chroma.bit_depth = chroma_bits;
      frame.chroma.step_bytes = step;
      frame.chroma.stride_bytes = kWidth / 2 * step * bytes;
      double sum_cr = 0.0, sum_cb = 0.0;
      int n = 0;
      for (int v = 3; v <= 22; ++v)
        for (int u = 8; u <= 32; ++u) {
          const int code = frame.luma.code(u, v);
          if (code < kLevel || code >= kClip) continue;
          sum_cr += frame.chroma.cr_fraction(u, v);
          sum_cb += frame.chroma.cb_fraction(u, v);
          ++n;
        }
      const RimColour rim = rim_colour(frame, {10, 5, 30, 20}, kLevel, kClip);
      EXPECT_TRUE(rim.known);
      EXPECT_NEAR(rim.cr, sum_cr / n, kRounding);
      EXPECT_NEAR(rim.cb, sum_cb / n, kRounding);
    }
}

// Colour differences of one paint grow with the light: at a quarter of the luma a red lamp shows a
// quarter of them.
TEST(OwnColour, OfADimRedLampIsRedAndOfADimWhiteOneWhite) {
  constexpr int kClip = 235, kDark = 20;
  const auto at = [](double share, double cr, double cb) {
    return own_colour({true, share * cr, share * cb, kDark + share * 0.4 * kClip}, kDark, kClip);
  };
  const RimColour bright = at(1.0, 0.16, -0.04);
  EXPECT_NEAR(bright.cr, 0.16, 1e-9);
  EXPECT_NEAR(bright.cb, -0.04, 1e-9);
  const RimColour dim = at(0.25, 0.16, -0.04), white = at(0.25, 0.012, -0.015);
  EXPECT_LT(tail_lamp_log_odds(0.25 * 0.16, 0.25 * -0.04), 0.0);  // as it stands
  EXPECT_GT(tail_lamp_log_odds(dim.cr, dim.cb), 1.0);
  EXPECT_LT(tail_lamp_log_odds(white.cr, white.cb), -1.5);
  // What is hardly brighter than its surroundings, or as coding leaves it, is not made red.
  const RimColour faint = own_colour({true, 0.02, 0.0, kDark + 1.0}, kDark, kClip);
  EXPECT_LT(tail_lamp_log_odds(faint.cr, faint.cb), 0.0);
  EXPECT_FALSE(own_colour({}, kDark, kClip).known);
  // Coding's 0.02 grow with the colour: 0.08 at a quarter, of which a bright lamp has 0.02 as well.
  EXPECT_EQ(bright.chance, 0.0);
  EXPECT_NEAR(std::hypot(dim.chance, 0.02), 0.08, 1e-9);
}

TEST(Kind, ANearDimLampIsAsManyTimesWiderAsThePictureIsFiner) {
  Measured light;
  light.background = 0.01;
  light.spread_px.setConstant(8.0);
  light.elongation = 1.1;
  const RimColour white{true, 0.0, 0.0, 150.0};
  EXPECT_EQ(kind_of({}, light, 0.2, white, 1.0), LampKind::other);
  EXPECT_EQ(kind_of({}, light, 0.2, white, 2.0), LampKind::headlamp);
  EXPECT_EQ(px_per_usual(1280, 720), 1.0);
  EXPECT_EQ(px_per_usual(2160, 3840), 2.0);
}

// The disc of one ahead, and its image on the road.
TEST(Kind, ANearDimLampThatIsRedAndRoundIsATailLamp) {
  Measured light;
  light.background = 0.004;
  light.spread_px.setConstant(8.0);
  light.elongation = 1.1;
  const RimColour red{true, 0.2, -0.05, 150.0};
  EXPECT_EQ(kind_of({}, light, 0.015, red, 1.0), LampKind::taillamp);
  light.elongation = 1.5;
  EXPECT_EQ(kind_of({}, light, 0.015, red, 1.0), LampKind::other);
}

// A tail lamp outshines a lit road three to five times.
TEST(Kind, RedLightsNeedToOutshineLess) {
  Measured light;
  light.background = 0.1;
  light.spread_px.setConstant(1.8);
  light.elongation = 1.1;
  const Peak peak;
  const RimColour red{true, 0.2, -0.05, 150.0}, grey{true, 0.0, 0.0, 150.0};
  ASSERT_GT(tail_lamp_log_odds(red.cr, red.cb), 4.0);
  EXPECT_EQ(kind_of(peak, light, 0.35, red, 1.0), LampKind::taillamp);
  EXPECT_EQ(kind_of(peak, light, 0.35, grey, 1.0), LampKind::other);
  EXPECT_EQ(kind_of(peak, light, 0.15, red, 1.0), LampKind::other);
  EXPECT_EQ(kind_of(peak, light, 0.65, grey, 1.0), LampKind::headlamp);
  light.elongation = 4.0;  // a line, or a strip of red LEDs
  EXPECT_EQ(kind_of(peak, light, 0.65, grey, 1.0), LampKind::other);
  EXPECT_EQ(kind_of(peak, light, 0.35, red, 1.0), LampKind::taillamp);
  light.elongation = 9.0;
  EXPECT_EQ(kind_of(peak, light, 0.35, red, 1.0), LampKind::other);
}

}  // namespace
}  // namespace vildar
