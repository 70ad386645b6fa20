#include "core/clock.h"

#include <gtest/gtest.h>

#include <type_traits>

namespace vildar {
namespace {

template <class A, class B>
concept Subtractable = requires(A a, B b) {
  a - b;
};

TEST(Clock, DevicesDoNotMix) {
  static_assert(Subtractable<CameraTime, CameraTime>);
  static_assert(!Subtractable<CameraTime, DiodeTime>);
  static_assert(!std::is_convertible_v<DiodeTime, CameraTime>);
}

TEST(Clock, SecondsComeBackToTheNanosecond) {
  constexpr double kHalfNanosecond_s = 0.5e-9;
  for (const double time_s : {0.0, 1.0 / 3.0, -2.75, 3600.123456789})
    EXPECT_NEAR(seconds_of(time_from_seconds<CameraTime>(time_s)), time_s,
                kHalfNanosecond_s + 1e-12);
  EXPECT_EQ(time_from_seconds<DiodeTime>(-1.6e-9).time_since_epoch().count(), -2);
}

TEST(Clock, RowsHoldAtTheirPlaceInTheReadout) {
  // Row v of H holds at t_s + ((v + 0.5) / H - 0.5) * rolling_shutter_s.
  const CameraTime frame = time_from_seconds<CameraTime>(2.0);
  EXPECT_EQ(row_time(frame, 0.02, 0.0), frame);
  EXPECT_NEAR(seconds_of(row_time(frame, 0.02, 0.5 / 1080 - 0.5)), 1.990009259, 1e-9);
  EXPECT_NEAR(seconds_of(row_time(frame, 0.02, 1079.5 / 1080 - 0.5)), 2.009990741, 1e-9);
}

}  // namespace
}  // namespace vildar
