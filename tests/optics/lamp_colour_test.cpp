#include "optics/lamp_colour.h"

#include <cmath>

#include <gtest/gtest.h>

namespace vildar {
namespace {

TEST(LampColour, WhiteYellowAndBlueLightsAreHeadlamps) {
  EXPECT_LT(tail_lamp_log_odds(0.0, 0.0), -2.0);      // grey
  EXPECT_LT(tail_lamp_log_odds(0.05, -0.06), -1.0);   // halogen under sodium light
  EXPECT_LT(tail_lamp_log_odds(-0.085, 0.10), -5.0);  // blue LED
}

// White light mixed with yellow, which is (0.081, -0.5) by BT.601; and the rims of halogen lamps at
// dusk, photographed.
TEST(LampColour, YellowIsNoRed) {
  for (const double share : {0.1, 0.2, 0.3, 0.5, 1.0})
    EXPECT_LT(tail_lamp_log_odds(share * 0.081, share * -0.5), 0.0) << share;
  EXPECT_LT(tail_lamp_log_odds(0.05, -0.16), 0.0);
  EXPECT_LT(tail_lamp_log_odds(0.10, -0.16), 0.0);
}

TEST(LampColour, RedLightsAreTailLamps) {
  EXPECT_GT(tail_lamp_log_odds(0.115, -0.06), 1.0);  // half whitened by clipping
  EXPECT_GT(tail_lamp_log_odds(0.22, -0.01), 5.0);
  EXPECT_GT(tail_lamp_log_odds(0.5 * 0.7, -0.06), 5.0);
}

TEST(LampColour, GreenLightsAreNoTailLamps) {
  EXPECT_LT(tail_lamp_log_odds(-0.10, 0.00), -2.0);   // a greenish LED
  EXPECT_LT(tail_lamp_log_odds(-0.25, -0.05), -2.0);  // a traffic light
  EXPECT_LT(tail_lamp_log_odds(-0.20, 0.05), -2.0);
}

// Mixed with white light, a tail lamp's odds fall steadily.
TEST(LampColour, OddsFallAsRedIsWhitened) {
  double last = tail_lamp_log_odds(0.2, -0.03);
  for (const double share : {0.8, 0.6, 0.4, 0.2, 0.0}) {
    const double odds = tail_lamp_log_odds(share * 0.2, share * -0.03);
    EXPECT_LT(odds, last) << share;
    last = odds;
  }
  EXPECT_LT(last, 0.0);
}

TEST(LampColour, OfFaintLightsTellsLittle) {
  for (const double cr : {0.0, 0.05, 0.12, 0.2})
    EXPECT_DOUBLE_EQ(faint_tail_lamp_log_odds(cr, -0.03, 0.0), tail_lamp_log_odds(cr, -0.03));
  // Grey is white for sure, but for what is so faint that coding leaves no colour.
  double last = tail_lamp_log_odds(0.0, 0.0);
  EXPECT_TRUE(colour_tells(0.0, 0.0, 0.0));
  for (const double chance : {0.02, 0.05, 0.1, 0.5}) {
    const double odds = faint_tail_lamp_log_odds(0.0, 0.0, chance);
    EXPECT_GT(odds, last) << chance;
    EXPECT_LT(odds, 0.0) << chance;
    last = odds;
  }
  EXPECT_GT(last, -0.1);
  EXPECT_FALSE(colour_tells(0.0, 0.0, 0.1));
  // Red enough is red, however faint.
  EXPECT_TRUE(colour_tells(0.2, -0.03, 0.1));
}

}  // namespace
}  // namespace vildar
