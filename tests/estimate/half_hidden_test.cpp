#include "estimate/half_hidden.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <vector>

#include <gtest/gtest.h>

#include "core/clock.h"

#include "estimate/vehicle.h"
#include "simulated_pass.h"

namespace vildar {
namespace {

using simulated::mast_site;
using simulated::track_of;
using simulated::Vehicle;
using simulated::View;

constexpr Vehicle kCar{.along_m = 70.0};
constexpr View kLong{.to_s = 2.8, .sigma_px = 0.3};

VehicleTrack seen_track() {
  Random random(3);
  return track_of(kCar, mast_site(5.0), kLong, random);
}

/// Of the right lamp a sliver is left until `until_s`, to one side of its middle.
VehicleTrack hidden_until(double until_s) {
  VehicleTrack track = seen_track();
  for (std::size_t k = 0; k < track.sightings.size(); ++k) {
    LampSighting& right = *track.sightings[k].right;
    if (static_cast<double>(k) / kLong.frame_rate_hz > until_s) break;
    right.flux *= 0.2;
    right.centre_px.x() += 3.0;
  }
  return track;
}

TEST(HalfHidden, ASliverOfALampSaysNothingOfItsPlace) {
  const auto outcome = estimate_vehicle(hidden_until(1.2), mast_site(5.0), {}).result;
  ASSERT_FALSE(outcome.withheld);
  EXPECT_LT(std::abs(outcome.speed.speed_mps - kCar.speed_mps), 2.5 * outcome.speed.std_mps);
}

TEST(HalfHidden, GoesWhereTheLampsAreAlikeElsewhere) {
  const VehicleTrack whole = without_half_hidden(hidden_until(1.2));
  int gone = 0;
  for (const VehicleSighting& one : whole.sightings) {
    EXPECT_TRUE(one.left);
    gone += !one.right;
  }
  EXPECT_EQ(gone, 37);
  EXPECT_FALSE(whole.sightings.front().right);
  EXPECT_TRUE(whole.sightings.back().right);
}

TEST(HalfHidden, ALampThatIsAlwaysTheFainterStays) {
  for (const VehicleSighting& one : without_half_hidden(hidden_until(9.0)).sightings)
    EXPECT_TRUE(one.left && one.right);
}

// From 1 to 2 s something comes before the right lamp, and stays: a disc whose rest moves aside by
// up to 0.6 px.
constexpr double kCoverFrom_s = 1.0, kCoveredAt_s = 2.0;

VehicleTrack covered_from(double from_s) {
  VehicleTrack track = seen_track();
  for (std::size_t k = 0; k < track.sightings.size(); ++k) {
    const double time_s = static_cast<double>(k) / kLong.frame_rate_hz;
    const double covered = std::max(0.0, (time_s - from_s) / (kCoveredAt_s - kCoverFrom_s));
    auto& right = track.sightings[k].right;
    right->flux *= 1.0 - covered;
    right->centre_px.x() -= 0.6 * covered;
    if (covered > 0.9) right.reset();
  }
  return track;
}

TEST(HalfHidden, WhileALampIsBeingCoveredItSaysNothingOfItsPlace) {
  const VehicleTrack whole = without_half_hidden(covered_from(kCoverFrom_s));
  for (std::size_t k = 0; k < whole.sightings.size(); ++k) {
    const double time_s = static_cast<double>(k) / kLong.frame_rate_hz;
    EXPECT_TRUE(whole.sightings[k].left);
    if (time_s >= kCoverFrom_s && time_s <= kCoverFrom_s + 0.2) continue;
    EXPECT_EQ(whole.sightings[k].right.has_value(), time_s < kCoverFrom_s) << time_s;
  }
}

TEST(HalfHidden, WhatUncoversIsAsWhatIsBeingCovered) {
  VehicleTrack backwards = covered_from(kCoverFrom_s);
  std::vector<CameraTime> times;
  for (const VehicleSighting& one : backwards.sightings) times.push_back(one.time);
  std::ranges::reverse(backwards.sightings);
  for (std::size_t k = 0; k < times.size(); ++k) backwards.sightings[k].time = times[k];
  const VehicleTrack whole = without_half_hidden(backwards);
  const auto rights = [](const VehicleTrack& track) {
    return std::ranges::count_if(track.sightings, [](const auto& one) { return !!one.right; });
  };
  EXPECT_EQ(rights(whole), rights(without_half_hidden(covered_from(kCoverFrom_s))));
  EXPECT_LT(rights(whole), rights(backwards) - 15);  // of the 27 from 1 to 1.9 s
}

// Its light falls, as in the beam's side, and it drives out of the image with the other.
TEST(HalfHidden, ALampThatDrivesOutOfTheImageFaintlyStays) {
  VehicleTrack track = covered_from(kCoverFrom_s);
  std::erase_if(track.sightings,
                [](const VehicleSighting& one) { return seconds_of(one.time) > kCoveredAt_s; });
  const VehicleTrack whole = without_half_hidden(track);
  const auto rights = std::ranges::count_if(whole.sightings,
                                            [](const VehicleSighting& one) { return !!one.right; });
  EXPECT_GT(rights, 40);
}

// A lamp alone that comes nearer, the first frames of it behind something.
VehicleTrack lone_track(int hidden_frames) {
  VehicleTrack track = seen_track();
  track.single_lamp = true;
  for (std::size_t k = 0; k < track.sightings.size(); ++k) {
    VehicleSighting& sighting = track.sightings[k];
    sighting.right.reset();
    const double ahead_m = 70.0 - 20.0 * static_cast<double>(k) / kLong.frame_rate_hz;
    sighting.left->flux = 1e6 / (ahead_m * ahead_m);
    if (static_cast<int>(k) < hidden_frames) sighting.left->flux *= 0.3;
  }
  return track;
}

TEST(HalfHidden, OfALampAloneTheEndsAtWhichItIsFainterThanItsLightThereAsksFor) {
  for (const int hidden : {0, 6}) {
    const VehicleTrack track = lone_track(hidden);
    const VehicleTrack whole = without_half_hidden(track);
    EXPECT_EQ(std::ssize(whole.sightings), std::ssize(track.sightings) - hidden);
    VehicleTrack backwards = track;
    std::ranges::reverse(backwards.sightings);
    const auto end_s = seconds_of(track.sightings.back().time);
    for (VehicleSighting& one : backwards.sightings)
      one.time =
          CameraTime(std::chrono::nanoseconds(std::llround((end_s - seconds_of(one.time)) * 1e9)));
    EXPECT_EQ(std::ssize(without_half_hidden(backwards).sightings),
              std::ssize(track.sightings) - hidden);
  }
}

}  // namespace
}  // namespace vildar
