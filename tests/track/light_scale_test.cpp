#include "track/light_scale.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vildar {
namespace {

TEST(LightScale, UpperQuartileOfTheLatest) {
  LightScale scale;
  scale.add(LampKind::headlamp, 1.0, 0.05, true);
  scale.add(LampKind::headlamp, 2.0, 0.05, true);
  EXPECT_FALSE(scale.typical(LampKind::headlamp));
  EXPECT_FALSE(scale.usually_clips(LampKind::headlamp));
  scale.add(LampKind::headlamp, 3.0, 0.05, false);
  scale.add(LampKind::headlamp, 4.0, 0.05, true);
  EXPECT_EQ(scale.typical(LampKind::headlamp), 4.0);
  EXPECT_TRUE(scale.usually_clips(LampKind::headlamp));
  EXPECT_FALSE(scale.typical(LampKind::taillamp));
  for (int i = 0; i < 100; ++i) scale.add(LampKind::headlamp, 10.0, 0.05, false);
  EXPECT_EQ(scale.typical(LampKind::headlamp), 10.0);
  EXPECT_FALSE(scale.usually_clips(LampKind::headlamp));
}

TEST(LightScale, OneLampTellsOnlyWhatIsFarFainter) {
  LightScale scale;
  EXPECT_FALSE(scale.at_least(LampKind::headlamp));
  scale.add(LampKind::taillamp, 2.0, 0.05, false);
  EXPECT_FALSE(scale.at_least(LampKind::headlamp));  // which may be far stronger
  scale.add(LampKind::headlamp, 5.0, 0.05, false);
  EXPECT_EQ(scale.at_least(LampKind::headlamp), 4.0);
  for (int i = 0; i < 2; ++i) scale.add(LampKind::headlamp, 5.0, 0.05, false);
  EXPECT_EQ(scale.at_least(LampKind::headlamp), 5.0);
}

TEST(LightScale, TailLampsTellHowStrongHeadlampsAreAtLeastAndNotAtMost) {
  LightScale scale;
  for (int i = 0; i < 5; ++i) scale.add(LampKind::taillamp, 2.0, 0.05, false);
  EXPECT_EQ(scale.typical(LampKind::headlamp), 2.0);
  EXPECT_FALSE(scale.knows(LampKind::headlamp));
  EXPECT_TRUE(scale.knows(LampKind::taillamp));
}

TEST(LightScale, NoiseIsNoColourAndOneTailLampInAHundredIs) {
  LightScale grey, coloured;
  EXPECT_FALSE(grey.colourless());
  for (int i = 0; i < 100; ++i) {
    const double noise = i % 2 == 0 ? 0.001 : -0.001;
    grey.see_colour(noise, -noise);
    coloured.see_colour(i == 50 ? 0.12 : noise, i == 50 ? -0.05 : -noise);
  }
  EXPECT_TRUE(grey.colourless());
  EXPECT_FALSE(coloured.colourless());
  // White lamps alone, as a camera sees them that knows colours.
  LightScale white;
  for (int i = 0; i < 100; ++i) white.see_colour(i % 2 == 0 ? 0.004 : -0.002, 0.001);
  EXPECT_FALSE(white.colourless());
}

TEST(LightScale, HeadlampsAreNoFainterThanTaillamps) {
  LightScale scale;
  for (int i = 0; i < 3; ++i) {
    scale.add(LampKind::headlamp, 5.0, 0.05, false);
    scale.add(LampKind::taillamp, 8.0, 0.05, false);
  }
  EXPECT_EQ(scale.typical(LampKind::headlamp), 8.0);
  EXPECT_EQ(scale.typical(LampKind::taillamp), 8.0);
}

// From 3 to 17 degrees up low beams may lose a factor of ten or so; tail lamps do not.
TEST(LightScale, IsLessForHeadlampsSeenFromSteeplyAbove) {
  LightScale scale;
  for (int i = 0; i < 3; ++i) {
    scale.add(LampKind::headlamp, 9.0, 0.06, false);
    scale.add(LampKind::taillamp, 5.0, 0.06, false);
  }
  EXPECT_EQ(scale.dimmer_ln(0.02, LampKind::headlamp), 0.0);
  EXPECT_EQ(scale.dimmer_ln(0.06, LampKind::headlamp), 0.0);
  const double dimmer = scale.dimmer_ln(0.3, LampKind::headlamp);
  EXPECT_GT(dimmer, std::log(6.0));
  EXPECT_LT(dimmer, std::log(20.0));
  EXPECT_EQ(scale.dimmer_ln(0.3, LampKind::taillamp), 0.0);
  EXPECT_GT(LightScale().dimmer_ln(0.3, LampKind::headlamp), dimmer) << "from 3 degrees on";
}

}  // namespace
}  // namespace vildar
