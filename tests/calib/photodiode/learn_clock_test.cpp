#include "calib/photodiode/learn_clock.h"

#include <cmath>

#include <gtest/gtest.h>

#include "far.h"
#include "simulated_rims.h"

namespace vildar {
namespace {

ClockLearning learned(const simulated::TimedPasses& scene) {
  const auto outcome = learn_clock(scene.passes, scene.site);
  if (const Miss* miss = std::get_if<Miss>(&outcome))
    throw std::runtime_error(std::string(name_of(*miss)));
  return std::get<ClockLearning>(outcome);
}

TEST(LearnClock, FindsTheOffset) {
  const simulated::TimedPasses scene = simulated::timed_passes(15, {.time_offset_s = 0.013}, 3);
  const ClockLearning learning = learned(scene);
  const Uncertain& after = learning.clock.after;
  EXPECT_GE(learning.clock.passes, 11);
  EXPECT_LT(std::abs(after.mean - 0.013), kFar * after.std);
  EXPECT_LT(after.std, 0.006);  // of 0.02 before
  EXPECT_EQ(learning.site.photodiodes[0].time_offset_s, after);
}

// As of a lorry that something covers, or of a motorcycle beside which nothing shines.
TEST(LearnClock, LightThatGoesAtOnceTellsItToo) {
  const simulated::TimedPasses scene =
      simulated::timed_passes(15, {.time_offset_s = 0.013, .one_lamp = true}, 9);
  const Uncertain after = learned(scene).clock.after;
  EXPECT_LT(std::abs(after.mean - 0.013), kFar * after.std);
  EXPECT_LT(after.std, 0.006);
}

TEST(LearnClock, ARimThatIsElsewhereIsNoOffset) {
  const double off_rad = radians_from_degrees(1.5);
  const simulated::TimedPasses scene =
      simulated::timed_passes(40, {.rim_off_rad = {off_rad, -off_rad}}, 4);
  const Uncertain after = learned(scene).clock.after;
  EXPECT_LT(std::abs(after.mean), kFar * after.std);
  EXPECT_LT(after.std, 0.006);
}

TEST(LearnClock, FindsAnOffsetOfASecond) {
  const simulated::TimedPasses scene =
      simulated::timed_passes(15, {.time_offset_s = -1.1, .offset_std_s = 1.0}, 5);
  const Uncertain after = learned(scene).clock.after;
  EXPECT_LT(std::abs(after.mean + 1.1), kFar * after.std);
  EXPECT_LT(after.std, 0.006);
}

// A view that fades out has no rim.
TEST(LearnClock, LightThatFadesTellsNothing) {
  const simulated::TimedPasses scene =
      simulated::timed_passes(12, {.time_offset_s = 0.02, .rim_width_rad = 0.15}, 6);
  const ClockLearning learning = learned(scene);
  EXPECT_LT(learning.clock.passes, kFewestClockPasses);
  EXPECT_EQ(learning.site.photodiodes[0].time_offset_s, scene.site.photodiodes[0].time_offset_s);
  EXPECT_GE(learning.left_out.at("light_does_not_fall"), 8);
}

TEST(LearnClock, APassUnlikeTheOthersIsLeftOut) {
  simulated::TimedPasses scene = simulated::timed_passes(15, {.time_offset_s = 0.01}, 7);
  const int passes = learned(scene).clock.passes;
  // The lamps of one go behind a lorry 0.2 s before they reach the rim.
  PowerTrace& trace = scene.traces[3][0];
  const auto last =
      static_cast<std::size_t>(std::ranges::max_element(trace.power_w) - trace.power_w.begin());
  for (std::size_t i = last - 150; i < trace.power_w.size(); ++i)
    trace.power_w[i] = static_cast<float>(trace.ambient_w);
  const ClockLearning learning = learned(scene);
  EXPECT_EQ(learning.clock.passes, passes - 1);
  const Uncertain& after = learning.clock.after;
  EXPECT_LT(std::abs(after.mean - 0.01), kFar * after.std);
}

// A rim of 25 degrees lies within the camera's view, too.
TEST(LearnClock, ANarrowViewTellsIt) {
  const simulated::TimedPasses scene = simulated::timed_passes(
      15, {.time_offset_s = -0.02, .half_view_rad = radians_from_degrees(25.0)}, 10);
  const ClockLearning learning = learned(scene);
  EXPECT_GE(learning.clock.passes, 13);
  EXPECT_LT(std::abs(learning.clock.after.mean + 0.02), kFar * learning.clock.after.std);
}

TEST(LearnClock, StampsMayBeUneven) {
  const simulated::TimedPasses scene =
      simulated::timed_passes(15, {.time_offset_s = 0.013, .jitter = 0.9}, 11);
  const ClockLearning learning = learned(scene);
  EXPECT_GE(learning.clock.passes, 10);
  EXPECT_LT(std::abs(learning.clock.after.mean - 0.013), kFar * learning.clock.after.std);
}

// As of two runs, each begun at a time of its own.
TEST(LearnClock, ClocksThatDifferAreNotOne) {
  simulated::TimedPasses scene = simulated::timed_passes(20, {.offset_std_s = 0.2}, 12);
  for (std::size_t i = 0; i < scene.traces.size(); i += 2)
    for (double& time_s : scene.traces[i][0].time_s) time_s += 0.3;
  const ClockLearning learning = learned(scene);
  EXPECT_FALSE(learning.clock.learned);
  EXPECT_GE(learning.left_out.at("unlike_the_others"), 5);
  EXPECT_EQ(learning.site.photodiodes[0].time_offset_s, scene.site.photodiodes[0].time_offset_s);
}

TEST(LearnClock, SaysWhatIsMissing) {
  simulated::TimedPasses scene = simulated::timed_passes(4, {.time_offset_s = 0.01}, 8);
  const ClockLearning few = learned(scene);
  EXPECT_LE(few.clock.passes, 4);
  EXPECT_EQ(few.site.photodiodes[0].time_offset_s, scene.site.photodiodes[0].time_offset_s);
  const auto miss = [&] { return std::get<Miss>(learn_clock(scene.passes, scene.site)); };
  PhotodiodeSite& photodiode = scene.site.photodiodes[0];
  photodiode.time_offset_s.std = 0.0;
  EXPECT_EQ(miss(), Miss::unobservable);
  scene.site.photodiodes.push_back(photodiode);
  scene.site.photodiodes[1].time_offset_s = {0.3, 0.02};
  EXPECT_EQ(miss(), Miss::outside_model) << "one clock, two offsets";
  scene.site.photodiodes.clear();
  EXPECT_EQ(miss(), Miss::unobservable);
}

}  // namespace
}  // namespace vildar
