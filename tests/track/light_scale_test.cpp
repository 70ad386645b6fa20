#include "track/light_scale.h"

#include <gtest/gtest.h>

namespace vildar {
namespace {

TEST(LightScale, UpperQuartileOfTheLatest) {
  LightScale scale;
  scale.add(LampKind::headlamp, 1.0, true);
  scale.add(LampKind::headlamp, 2.0, true);
  EXPECT_FALSE(scale.typical(LampKind::headlamp));
  EXPECT_FALSE(scale.usually_clips(LampKind::headlamp));
  scale.add(LampKind::headlamp, 3.0, false);
  scale.add(LampKind::headlamp, 4.0, true);
  EXPECT_EQ(scale.typical(LampKind::headlamp), 4.0);
  EXPECT_TRUE(scale.usually_clips(LampKind::headlamp));
  EXPECT_FALSE(scale.typical(LampKind::taillamp));
  for (int i = 0; i < 100; ++i) scale.add(LampKind::headlamp, 10.0, false);
  EXPECT_EQ(scale.typical(LampKind::headlamp), 10.0);
  EXPECT_FALSE(scale.usually_clips(LampKind::headlamp));
}

TEST(LightScale, HeadlampsAreNoFainterThanTaillamps) {
  LightScale scale;
  for (int i = 0; i < 3; ++i) {
    scale.add(LampKind::headlamp, 5.0, false);
    scale.add(LampKind::taillamp, 8.0, false);
  }
  EXPECT_EQ(scale.typical(LampKind::headlamp), 8.0);
  EXPECT_EQ(scale.typical(LampKind::taillamp), 8.0);
}

}  // namespace
}  // namespace vildar
