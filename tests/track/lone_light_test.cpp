#include "track/lone_light.h"

#include <cmath>

#include <gtest/gtest.h>

namespace vildar {
namespace {

TEST(LoneLight, OddsFallWithEveryCueOfAGlint) {
  const LoneLight lamp{0.0, 0.0, 1.0, true, -0.4};
  double last = lone_lamp_log_odds(lamp);
  EXPECT_GT(last, std::log(20.0));
  for (const double share : {0.2, 0.4, 0.6, 0.8, 1.0}) {
    const LoneLight light{share, share, 1.0 - share, true, -0.4 - 2.0 * share};
    EXPECT_LT(lone_lamp_log_odds(light), last) << share;
    last = lone_lamp_log_odds(light);
  }
  EXPECT_LT(last, -std::log(20.0));
}

TEST(LoneLight, NotToClipSpeaksAgainstALampOnlyWhereLampsClip) {
  for (const bool lamps_clip : {false, true}) {
    const double dim = lone_lamp_log_odds({0.0, 0.0, 0.0, lamps_clip, {}});
    const double clipped = lone_lamp_log_odds({0.0, 0.0, 1.0, lamps_clip, {}});
    EXPECT_GT(clipped, dim);
    EXPECT_EQ(dim > 0.0, !lamps_clip);
  }
}

TEST(LoneLight, AHighBeamIsNoLessALamp) {
  EXPECT_DOUBLE_EQ(lone_lamp_log_odds({0.0, 0.0, 1.0, true, -0.4}),
                   lone_lamp_log_odds({0.0, 0.0, 1.0, true, 2.0}));
}

TEST(LoneLight, SeveralLampsInOneAreNoLamp) {
  EXPECT_LT(lone_lamp_log_odds({0.0, 0.0, 1.0, true, 4.0}), -std::log(20.0));
}

}  // namespace
}  // namespace vildar
