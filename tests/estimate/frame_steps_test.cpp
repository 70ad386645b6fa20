#include "estimate/frame_steps.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <random>
#include <set>
#include <vector>

namespace vildar {
namespace {

constexpr double kRate_hz = 30.0;

CameraTime at(double time_s) {
  return CameraTime{std::chrono::nanoseconds(std::llround(1e9 * time_s))};
}

/// Two lamps on their way from 60 to 15 m before a camera 5 m high, by their projection.
class Clip {
 public:
  explicit Clip(double noise_px) : noise_px_(noise_px) {}

  /// A frame that shows the vehicle at `real_s`, stamped `stamp_s`.
  void show(double real_s, double stamp_s, const Eigen::Vector2d& shift_px = {0.0, 0.0}) {
    constexpr double kFocal_px = 540.0, kHeight_m = 4.3, kSpeed_mps = 20.0;
    VehicleSighting sighting;
    sighting.frame = static_cast<std::int64_t>(track_.sightings.size());
    sighting.time = at(stamp_s);
    const double range_m = 60.0 - kSpeed_mps * real_s;
    for (const double side_m : {-0.6, 0.6}) {
      LampSighting lamp;
      lamp.centre_px = shift_px + kFocal_px / range_m * Eigen::Vector2d(3.0 + side_m, kHeight_m) +
                       noise_px_ * Eigen::Vector2d(normal_(random_), normal_(random_));
      lamp.centre_sigma_px.setConstant(std::max(noise_px_, 0.02));
      (side_m < 0.0 ? sighting.left : sighting.right) = lamp;
    }
    track_.sightings.push_back(sighting);
  }
  /// All frames but those in `lost`, stamped as if none were.
  void show_but(const std::set<int>& lost) {
    for (int i = 0; i < 68; ++i)
      if (!lost.contains(i)) {
        const auto stamp = static_cast<double>(track_.sightings.size());
        show(i / kRate_hz, stamp / kRate_hz);
      }
  }
  FrameSteps steps() const {
    FrameSteps steps;
    steps.add(track_);
    return steps;
  }
  std::mt19937_64& random() { return random_; }

 private:
  double noise_px_;
  std::mt19937_64 random_{11};
  std::normal_distribution<double> normal_;
  VehicleTrack track_;
};

TEST(FrameSteps, CountsFramesThatTheStampsLeaveOut) {
  Clip clip(0.1);
  clip.show_but({20, 30, 31, 40, 47});
  const FrameSteps steps = clip.steps();
  EXPECT_EQ(steps.all().missing, 5);
  EXPECT_EQ(steps.all().jumps, 4);
  EXPECT_EQ(steps.all().unfilled(), 5);
  EXPECT_GT(steps.all().judged, 45);
  EXPECT_NEAR(steps.missing_share(0, 63), 5.0 / static_cast<double>(steps.all().judged), 1e-12);
  EXPECT_EQ(steps.between(0, 15).missing, 0);
  EXPECT_EQ(steps.between(0, 15).unfilled(), 0);
}

TEST(FrameSteps, OneInSixIsNoHindrance) {
  Clip clip(0.1);
  clip.show_but({8, 13, 14, 22, 29, 33, 39, 45, 50, 56, 60});
  EXPECT_NEAR(clip.steps().missing_share(0, 56), 11.0 / 57.0, 0.05);
}

TEST(FrameSteps, FindsNothingWhereNoneIsMissing) {
  for (const double noise_px : {0.0, 0.1, 0.5, 2.0}) {
    Clip clip(noise_px);
    clip.show_but({});
    EXPECT_EQ(clip.steps().all().unfilled(), 0) << noise_px;
    EXPECT_EQ(clip.steps().missing_share(0, 67), 0.0) << noise_px;
  }
}

TEST(FrameSteps, TimeThatTheStampsTellIsNotMissing) {
  Clip clip(0.1);
  for (int i = 0; i < 68; ++i)
    if (i % 7 != 3) clip.show(i / kRate_hz, i / kRate_hz);
  EXPECT_EQ(clip.steps().all().unfilled(), 0);
  EXPECT_GT(clip.steps().all().judged, 35);
}

TEST(FrameSteps, AFrameShownTwiceFillsTheTimeOfOneThatIsMissing) {
  Clip clip(0.1);
  for (int i = 0; i < 68; ++i) {
    const bool twice = i == 20 || i == 33 || i == 45 || i == 52;
    clip.show((twice ? i - 1 : i) / kRate_hz, i / kRate_hz);
  }
  const FrameSteps::Tally tally = clip.steps().all();
  EXPECT_EQ(tally.repeated, 4);
  EXPECT_EQ(tally.missing, 4);
  EXPECT_EQ(tally.unfilled(), 0);
}

// As a real clip of 25 frames a second made from 30: one in six is left out, and the stamps of the
// others are right on the whole.
TEST(FrameSteps, AClipGivenAnotherRateHasItsTime) {
  Clip clip(0.1);
  int shown = 0;
  for (int i = 0; i < 68; ++i)
    if (i % 6 != 5) clip.show(i / kRate_hz, shown++ / 25.0);
  EXPECT_GE(clip.steps().all().missing, FrameSteps::kFewestMissing);
  EXPECT_EQ(clip.steps().all().unfilled(), 0);
}

// One in eight or five left out gives no rate that a camera has.
TEST(FrameSteps, FramesMissingRegularlyAreMissing) {
  for (const int each : {8, 5}) {
    Clip clip(0.02);
    int shown = 0;
    for (int i = 0; i < 68; ++i)
      if (i % each != each - 1) clip.show(i / kRate_hz, shown++ / kRate_hz);
    EXPECT_NEAR(clip.steps().missing_share(0, shown - 1), 1.0 / (each - 1), 0.05) << each;
  }
}

TEST(FrameSteps, ACameraThatShakesLosesNoFrames) {
  Clip clip(0.1);
  std::normal_distribution<double> shift_px(0.0, 0.3);
  for (int i = 0; i < 68; ++i)
    clip.show(i / kRate_hz, i / kRate_hz, {shift_px(clip.random()), shift_px(clip.random())});
  EXPECT_GT(clip.steps().all().judged, 5);
  EXPECT_EQ(clip.steps().missing_share(0, 67), 0.0);
}

// Each time by some part of the lamps' way, now and then by about a whole one.
TEST(FrameSteps, ACameraThatIsNudgedLosesNoFrames) {
  Clip clip(0.05);
  std::uniform_real_distribution<double> ways(0.4, 1.6);
  Eigen::Vector2d shift_px(0.0, 0.0);
  for (int i = 0; i < 68; ++i) {
    const double range_m = 60.0 - 20.0 * i / kRate_hz;
    if (i > 12 && i % 5 == 0)
      shift_px += ways(clip.random()) * 540.0 * 20.0 / kRate_hz / (range_m * range_m) *
                  Eigen::Vector2d(3.0, 4.3);
    clip.show(i / kRate_hz, i / kRate_hz, shift_px);
  }
  const FrameSteps::Tally tally = clip.steps().all();
  EXPECT_GE(tally.missing - tally.repeated, FrameSteps::kFewestMissing);
  EXPECT_GE(tally.odd, 3);
  EXPECT_EQ(tally.unfilled(), 0);
}

TEST(FrameSteps, WhatTheCameraSeesIsTheClosingSpeed) {
  VehicleResult result;
  result.used_camera = true;
  result.speed.speed_mps = 20.0;
  result.speed.std_mps = 0.5;
  EXPECT_TRUE(bears_on(0.02, result));
  EXPECT_FALSE(bears_on(0.01, result));
  result.closing_speed_mps = 40.0;  // of a dashcam at 20 m/s
  EXPECT_TRUE(bears_on(0.01, result));
  result.closing_speed_mps = -0.5;  // of one ahead of it
  EXPECT_FALSE(bears_on(0.1, result));
  result.closing_speed_mps = 40.0;
  result.used_camera = false;  // photodiodes have their own clock
  EXPECT_FALSE(bears_on(0.1, result));
}

}  // namespace
}  // namespace vildar
