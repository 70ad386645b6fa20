#include "estimate/light_checks.h"

#include <gtest/gtest.h>

namespace vildar {
namespace {

TEST(LightChecks, LightThatPulsesIsAsUnsureAsItsDutyWhileItPulses) {
  PowerTraceFacts trace;
  trace.pulsing = {{2.0, 4.0, 200.0, 0.5, 0.01}, {3.0, 6.0, 150.0, 0.2, 0.01}};
  EXPECT_EQ(log_light_std(trace, 0.0, 2.0), 0.0);
  EXPECT_DOUBLE_EQ(log_light_std(trace, 1.0, 2.5), 0.01 / 0.5);
  EXPECT_DOUBLE_EQ(log_light_std(trace, 2.5, 3.5), 0.01 / 0.2);
  EXPECT_DOUBLE_EQ(log_light_std(trace, 5.0, 9.0), 0.01 / 0.2);
  EXPECT_EQ(log_light_std(trace, 6.0, 9.0), 0.0);
  EXPECT_EQ(log_light_std({}, 0.0, 9.0), 0.0);
}

TEST(LightChecks, ATimeIsMostlyClippedByTheStretchesWithinIt) {
  PowerTrace trace;
  trace.time_s = {0.0, 6.0};
  trace.clipped = {{-1.0, 1.0}, {2.0, 3.5}};
  EXPECT_FALSE(is_mostly_clipped(trace, 0.0, 6.0));
  EXPECT_TRUE(is_mostly_clipped(trace, 0.0, 4.0));
  EXPECT_TRUE(is_mostly_clipped(trace, 2.5, 4.0));
  EXPECT_FALSE(is_mostly_clipped(trace, 3.0, 20.0));  // it ends at 6 s
  EXPECT_FALSE(is_mostly_clipped(trace, 7.0, 9.0));
  EXPECT_FALSE(is_mostly_clipped({}, 0.0, 6.0));
}

}  // namespace
}  // namespace vildar
