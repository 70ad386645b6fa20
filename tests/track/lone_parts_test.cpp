#include "track/lone_parts.h"

#include <gtest/gtest.h>

namespace vildar {
namespace {

constexpr double kPartFrame_s = 0.04, kEverShare = 0.01;

LampSighting lamp_of(double flux, int width_px, int height_px) {
  LampSighting lamp;
  lamp.flux = flux;
  lamp.box = {100, 100, 100 + width_px - 1, 100 + height_px - 1};
  return lamp;
}

const LampSighting kLamp = lamp_of(1000.0, 6, 6);

class LoneParts : public ::testing::Test {
 protected:
  void see(std::optional<LampSighting> left, std::optional<LampSighting> right, bool fits = true,
           bool both_in_one = false) {
    const auto frame = static_cast<std::int64_t>(seen_.size());
    const CameraTime time{std::chrono::nanoseconds(
        static_cast<std::int64_t>(1e9 * kPartFrame_s * static_cast<double>(frame)))};
    seen_.push_back({{frame, time, left, right, both_in_one}, fits});
  }
  std::vector<std::int64_t> kept() {
    drop_strange_parts(seen_, kEverShare);
    std::vector<std::int64_t> frames;
    for (const SeenVehicle& one : seen_) frames.push_back(one.sighting.frame);
    return frames;
  }
  std::vector<SeenVehicle> seen_;
};

TEST_F(LoneParts, WhatIsTooWideOrOfOtherLightBeforeThePairIsNotItsLamp) {
  see(lamp_of(1000.0, 20, 30), {});  // several lamps in one
  see(kLamp, {});
  see(lamp_of(4000.0, 6, 6), {});
  see(lamp_of(4000.0, 6, 20), {});  // with its image on the road
  see({}, lamp_of(9000.0, 18, 18), true, true);
  see(kLamp, kLamp);
  EXPECT_EQ(kept(), (std::vector<std::int64_t>{1, 3, 4, 5}));
}

TEST_F(LoneParts, TwoLightsThatAreNoPairSayNothing) {
  see(kLamp, lamp_of(1000.0, 1, 4), false);
  see(kLamp, kLamp);
  see(kLamp, lamp_of(1000.0, 6, 30), false);
  see(kLamp, kLamp);
  EXPECT_EQ(kept(), (std::vector<std::int64_t>{1, 3}));
}

TEST_F(LoneParts, ALampMergedWithOthersLaterIsLeftOut) {
  see(kLamp, kLamp);
  see(lamp_of(1000.0, 14, 30), {});
  see(kLamp, {});
  EXPECT_EQ(kept(), (std::vector<std::int64_t>{0, 2}));
}

TEST_F(LoneParts, LongAfterThePairIsLeftOut) {
  see(kLamp, kLamp);
  for (int i = 0; i < 30; ++i) see(kLamp, {});
  EXPECT_EQ(kept().back(), 25);  // a second
}

// One more pair 1.6 s later, of what the lamp went over to and another light.
TEST_F(LoneParts, APairLongAwayFromThoseInARowVouchesForNothing) {
  for (int i = 0; i < 3; ++i) see(kLamp, kLamp);
  for (int i = 0; i < 40; ++i) see(kLamp, {});
  see(kLamp, kLamp);
  for (int i = 0; i < 10; ++i) see(kLamp, {});
  EXPECT_EQ(kept().back(), 27);  // a second after the last in a row
}

}  // namespace
}  // namespace vildar
