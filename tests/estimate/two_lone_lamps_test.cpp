#include "estimate/two_lone_lamps.h"

#include <cmath>

#include <gtest/gtest.h>

#include "estimate/vehicle.h"
#include "lamp_population.h"

namespace vildar {
namespace {

using simulated::Vehicle;
using simulated::View;

// A tripod beside the road: cars, lorries and motorcycles drive away, two lanes off.
Site tripod_site() {
  Site site = simulated::mixed_site(1.47);
  site.camera->yaw_rad = {radians_from_degrees(-5.0), radians_from_degrees(0.2)};
  site.camera->pitch_rad = {0.0, radians_from_degrees(0.2)};
  site.camera->roll_rad = {0.0, radians_from_degrees(0.2)};
  site.road.lanes = {{"far", {-7.0, 0.3}, 3.5, Direction::receding}};
  for (LampClass& one : site.lamps.classes)
    if (one.separation_m) {
      one.tail_height_m = Uncertain{0.85, 0.15};
      one.tail_separation_m = one.separation_m;
    }
  return site;
}

VehicleTrack driving_away(const Vehicle& vehicle, const Site& site, bool single_lamp) {
  const View view{.from_s = 1.0, .to_s = 5.0, .sigma_px = 0.1, .single_lamp = single_lamp};
  Random random(7);
  VehicleTrack track = simulated::track_of(vehicle, site, view, random);
  track.kind = LampKind::taillamp;
  track.direction = Direction::receding;
  return track;
}

// The lamps of two motorcycles, `ahead` to the left in the picture, as one vehicle's.
VehicleTrack taken_for_one(const Vehicle& ahead, const Vehicle& behind, const Site& site) {
  VehicleTrack pair = driving_away(ahead, site, true);
  const VehicleTrack other = driving_away(behind, site, true);
  pair.single_lamp = false;
  EXPECT_EQ(pair.sightings.size(), other.sightings.size());
  for (std::size_t k = 0; k < pair.sightings.size(); ++k)
    pair.sightings[k].right = other.sightings[k].left;
  return pair;
}

Vehicle motorcycle(double speed_mps, double along_m, double lateral_m) {
  return {-speed_mps, 0.0, along_m, lateral_m, 0.8, 0.0};
}

TEST(TwoLoneLamps, AreTwoMotorcyclesThatFollowEachOther) {
  const Site site = tripod_site();
  for (const double gap_m : {8.0, 12.0, 18.0, 25.0})
    for (const double ahead_mps : {13.0, 15.0}) {
      const VehicleTrack pair = taken_for_one(motorcycle(ahead_mps, 2.0 + gap_m, -6.8),
                                              motorcycle(13.0, 2.0, -7.3), site);
      const VehicleResult found = estimate_vehicle(pair, site, {}).result;
      ASSERT_TRUE(found.withheld) << gap_m;
      const auto lamps = two_lone_lamps(pair, found, site);
      ASSERT_TRUE(lamps) << gap_m << " m, " << name_of(*found.withheld);
      const auto expect_speed = [&](const VehicleTrack& lamp, double speed_mps) {
        const VehicleResult alone = estimate_vehicle(lamp, site, {}).result;
        ASSERT_FALSE(alone.withheld) << gap_m;
        EXPECT_LE(alone.speed.lo95_mps, speed_mps);
        EXPECT_GE(alone.speed.hi95_mps, speed_mps);
      };
      expect_speed(lamps->first, ahead_mps);
      expect_speed(lamps->second, 13.0);
    }
}

TEST(TwoLoneLamps, AreNotThoseOfACarWithheldForAnyReason) {
  const Site site = tripod_site();
  const VehicleTrack car = driving_away({-13.0, 0.0, 2.0, -7.0, 0.85, 1.25}, site, false);
  VehicleResult found = estimate_vehicle(car, site, {}).result;
  EXPECT_FALSE(found.withheld);
  for (const Miss miss : {Miss::bad_fit, Miss::not_on_road, Miss::ambiguous_identity}) {
    found.withheld = miss;
    EXPECT_FALSE(two_lone_lamps(car, found, site)) << name_of(miss);
  }
}

// Seen along one line at all times, as by an image or a lamp at another height of one body.
TEST(TwoLoneLamps, ThatReachTheCameraAtOnceAreNotTwoVehicles) {
  const Site site = tripod_site();
  constexpr double kRatio = 1.4;
  const VehicleTrack pair = taken_for_one(motorcycle(13.0 * kRatio, 2.0 * kRatio, -7.2),
                                          motorcycle(13.0, 2.0, -6.8), site);
  VehicleResult found;
  found.withheld = Miss::bad_fit;
  EXPECT_FALSE(two_lone_lamps(pair, found, site));
}

TEST(TwoLoneLamps, WhoseVehicleIsExplainedOrGoesOnAreLeft) {
  const Site site = tripod_site();
  VehicleTrack pair =
      taken_for_one(motorcycle(13.0, 14.0, -6.8), motorcycle(13.0, 2.0, -7.3), site);
  VehicleResult found;
  EXPECT_FALSE(two_lone_lamps(pair, found, site)) << "it has a speed";
  found.withheld = Miss::too_uncertain;
  EXPECT_FALSE(two_lone_lamps(pair, found, site));
  found.withheld = Miss::bad_fit;
  EXPECT_TRUE(two_lone_lamps(pair, found, site));
  pair.lamps_go_on = true;
  EXPECT_FALSE(two_lone_lamps(pair, found, site)) << "they are followed on, and told of there";
}

TEST(TwoLoneLamps, KeepWhatWasSeenOfEach) {
  const Site site = tripod_site();
  VehicleTrack pair =
      taken_for_one(motorcycle(13.0, 14.0, -6.8), motorcycle(13.0, 2.0, -7.3), site);
  pair.sightings[3].right.reset();
  pair.sightings[4].right.reset();
  pair.sightings[4].both_in_one = true;
  const auto [left, right] = lamps_alone(pair);
  EXPECT_EQ(left.sightings.size(), pair.sightings.size() - 1);
  EXPECT_EQ(right.sightings.size(), pair.sightings.size() - 2);
  EXPECT_TRUE(left.single_lamp && right.single_lamp);
  EXPECT_EQ(right.sightings[0].left->centre_px, pair.sightings[0].right->centre_px);
}

}  // namespace
}  // namespace vildar
