#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "core/text.h"
#include "estimate/one_place.h"
#include "seen_together.h"

namespace vildar {
namespace {

using namespace seen_together;

TEST(RoofLamps, LampsOnTheRoofRideOnTheirVehicle) {
  // Where they seem to be there is a lane, too.
  Site site = mast_site(5.0);
  for (const double lateral_m : {-7.5, -11.0})
    site.road.lanes.push_back({number_text(lateral_m), {lateral_m, 0.3}, 3.5, Direction::oncoming});
  const VehicleEstimate car = estimate_of(1, kCar, Frames::all);
  for (const double height_m : {1.8, 2.5, 3.4})
    for (const double back_m : {0.0, 2.0}) {
      const VehicleEstimate lamps =
          estimate_of(2, roof_lamps(height_m, back_m), Frames::all, kLong, site);
      ASSERT_GT(lamps.result.speed.speed_mps, 1.2 * kCar.speed_mps);
      EXPECT_TRUE(rides_on(lamps, car, kOverLamps_m)) << height_m << ", " << back_m;
      EXPECT_FALSE(rides_on(car, lamps, kOverLamps_m)) << height_m << ", " << back_m;
    }
}

// As far below a smooth road as the lamps are above it; drawn out toward them where it is rough.
VehicleEstimate image_of(const Vehicle& car, double height_m, double strength) {
  Vehicle image = car;
  image.height_m = height_m;
  View view = kLong;
  view.flux_at_1m *= strength;
  return estimate_of(2, image, Frames::all, view);
}

VehicleEstimate seen_as(VehicleEstimate estimate, int width_px, int height_px, bool clips = true) {
  for (TrackRow& row : estimate.rows)
    for (auto* lamp : {&row.sighting.left, &row.sighting.right})
      if (*lamp) {
        (*lamp)->box = {0, 0, width_px - 1, height_px - 1};
        (*lamp)->saturated_px = clips ? width_px * height_px / 2 : 0;
      }
  return estimate;
}

TEST(RoofLamps, AStreakThatClipsIsAnImageThoughItHasMoreLightThanItsLamp) {
  const VehicleEstimate car = seen_as(estimate_of(1, kCar, Frames::all), 8, 8);
  const VehicleEstimate image = image_of(kCar, -0.1, 4.0);
  EXPECT_TRUE(mirrors(seen_as(image, 8, 40), car, kOverLamps_m, kLampHeight_m));
  // Too much light for its size, and no taller than what is above it: lamps.
  EXPECT_FALSE(mirrors(seen_as(image, 8, 16), car, kOverLamps_m, kLampHeight_m));
  EXPECT_FALSE(mirrors(seen_as(image, 8, 40, false), car, kOverLamps_m, kLampHeight_m));
  EXPECT_FALSE(mirrors(seen_as(image, 20, 20), car, kOverLamps_m, kLampHeight_m));
  // Told by the frames in which it is tall, though it is so in two of five alone.
  VehicleEstimate at_times = seen_as(image, 20, 20);
  const VehicleEstimate tall = seen_as(image, 8, 40);
  for (std::size_t i = 0; i < at_times.rows.size(); ++i)
    if (i % 5 < 2) at_times.rows[i] = tall.rows[i];
  EXPECT_TRUE(mirrors(at_times, car, kOverLamps_m, kLampHeight_m));
}

TEST(RoofLamps, AnImageOnAWetRoadIsNoVehicle) {
  const VehicleEstimate car = estimate_of(1, kCar, Frames::all);
  for (const double height_m : {-0.65, -0.3, 0.1}) {
    const VehicleEstimate image = image_of(kCar, height_m, 0.4);
    ASSERT_LT(image.result.speed.speed_mps, 0.95 * kCar.speed_mps);
    EXPECT_TRUE(mirrors(image, car, kOverLamps_m, kLampHeight_m)) << height_m;
    EXPECT_FALSE(mirrors(car, image, kOverLamps_m, kLampHeight_m)) << height_m;
  }
  // Brighter than what is above it, it is no image of that unless it stands where a smooth road has
  // it: beams shine down on the road, and less up to a mast.
  EXPECT_FALSE(mirrors(image_of(kCar, -0.1, 2.0), car, kOverLamps_m, kLampHeight_m));
  EXPECT_TRUE(mirrors(image_of(kCar, -0.68, 2.0), car, kOverLamps_m, kLampHeight_m));
  for (const bool image_first : {true, false}) {
    MeasuredVehicles measured(kOverLamps_m, kLampHeight_m);
    if (image_first) measured.add(image_of(kCar, -0.65, 0.4));
    measured.add(estimate_of(1, kCar, Frames::all));
    if (!image_first) measured.add(image_of(kCar, -0.65, 0.4));
    for (const VehicleEstimate& one : measured.take_before(std::numeric_limits<double>::infinity()))
      EXPECT_EQ(one.result.withheld.has_value(), one.result.track_id == 2);
  }
}

// One of two on a lorry seen from a bridge, in whose lane it seems to drive, far faster.
TEST(RoofLamps, AMarkerThatSeemsToDriveInItsVehiclesLaneRidesOnIt) {
  Site site = mast_site(7.0);
  site.road.lanes[0].lateral_m.mean = -1.6;
  const Vehicle lorry{.along_m = 90.0, .lateral_m = -1.6, .height_m = 0.9};
  const VehicleEstimate seen = estimate_of(1, lorry, Frames::all, kLong, site);
  for (const double height_m : {3.0, 3.5}) {
    const Vehicle marker{
        .along_m = 91.0, .lateral_m = -0.8, .height_m = height_m, .separation_m = 0.0};
    const VehicleEstimate above = estimate_of(2, marker, Frames::all, lone(), site);
    ASSERT_EQ(above.result.lane, "near");
    ASSERT_GT(above.result.speed.speed_mps, 1.3 * lorry.speed_mps);
    EXPECT_TRUE(rides_on(above, seen, 7.0 - 0.68)) << height_m;
    EXPECT_FALSE(glints_beside(above, seen)) << height_m;
  }
}

// A marker at one upper corner of a bus, of which one headlamp is seen, at the other side.
TEST(RoofLamps, AMarkerAcrossFromTheOneLampThatIsSeenRidesOnIt) {
  Site site = mast_site(6.7);
  site.road.lanes[0].lateral_m = {-4.0, 1.0};
  const Vehicle lamp{.along_m = 80.0, .lateral_m = -4.9, .height_m = 0.8, .separation_m = 0.0};
  const Vehicle corner{.along_m = 80.5, .lateral_m = -2.9, .height_m = 3.0, .separation_m = 0.0};
  const VehicleEstimate seen = estimate_of(1, lamp, Frames::all, lone(), site);
  const VehicleEstimate above = estimate_of(2, corner, Frames::all, lone(), site);
  ASSERT_EQ(above.result.lane, "near");
  EXPECT_TRUE(rides_on(above, seen, 6.7 - kLampHeight_m));
}

// At either end of the row over a lorry's cab, where they seem to drive in the next lane.
TEST(RoofLamps, LampsAtTheEndOfARowOverTheCabRideOnTheLorry) {
  Site site = mast_site(6.4);
  site.road.lanes.push_back({"next", {-9.0, 0.3}, 3.5, Direction::oncoming});
  const VehicleEstimate seen = estimate_of(1, kCar, Frames::all, kLong, site);
  for (const double separation_m : {0.0, 0.35}) {
    const Vehicle end{.along_m = 70.0,
                      .lateral_m = kCar.lateral_m - (separation_m > 0.0 ? 0.9 : 1.35),
                      .height_m = 3.0,
                      .separation_m = separation_m};
    const VehicleEstimate above =
        estimate_of(2, end, Frames::all, separation_m > 0.0 ? kLong : lone(), site);
    ASSERT_EQ(above.result.lane, "next");
    ASSERT_GT(above.result.speed.speed_mps, 1.4 * kCar.speed_mps);
    EXPECT_TRUE(rides_on(above, seen, 6.4 - kLampHeight_m)) << separation_m;
  }
}

// For a second only, in which the lorry does not come much nearer: told by faint light alone.
TEST(RoofLamps, FaintOnesThatAreSeenBrieflyRideOnTheLorry) {
  Site site = mast_site(5.0);
  site.road.lanes.push_back({"next", {-7.0, 0.5}, 3.5, Direction::oncoming});
  const VehicleEstimate car = estimate_of(1, kCar, Frames::all);
  View brief = kLong;
  brief.to_s = 0.5;
  brief.sigma_px = 0.05;
  const Vehicle over_cab = roof_lamps(3.0, 0.5);
  EXPECT_FALSE(rides_on(estimate_of(2, over_cab, Frames::all, brief, site), car, kOverLamps_m));
  brief.flux_at_1m *= 0.05;
  EXPECT_TRUE(rides_on(estimate_of(2, over_cab, Frames::all, brief, site), car, kOverLamps_m));
}

// Farther back than a cab's roof is one in the next lane that is in line by chance.
TEST(RoofLamps, OneFourMetresBehindTheLineDoesNotRide) {
  Site site = mast_site(5.0);
  View sure = kLong;
  sure.sigma_px = 0.1;
  const VehicleEstimate car = estimate_of(1, kCar, Frames::all, sure);
  Vehicle beyond = kCar;
  beyond.speed_mps *= 1.6;
  beyond.along_m = 1.6 * (kCar.along_m + 4.2);
  beyond.lateral_m *= 1.75;
  site.road.lanes.push_back({"next", {beyond.lateral_m, 0.3}, 3.5, Direction::oncoming});
  const VehicleEstimate seen = estimate_of(2, beyond, Frames::all, sure, site);
  ASSERT_EQ(seen.result.lane, "next");
  EXPECT_FALSE(rides_on(seen, car, kOverLamps_m));
}

TEST(RoofLamps, WhatFollowsOrOvertakesDoesNotRideOnAnother) {
  const VehicleEstimate car = estimate_of(1, kCar, Frames::all);
  for (const double behind_m : {7.0, 15.0, 30.0, 60.0})
    for (const double speed_mps : {20.0, 26.0, 32.0}) {
      Vehicle behind = moved(kCar, behind_m, 0.0);
      behind.speed_mps = speed_mps;
      const VehicleEstimate follower = estimate_of(2, behind, Frames::all);
      EXPECT_FALSE(rides_on(follower, car, kOverLamps_m)) << behind_m << " m, " << speed_mps;
      EXPECT_FALSE(mirrors(car, follower, kOverLamps_m, kLampHeight_m))
          << behind_m << " m, " << speed_mps;
    }
  // Reaches the camera together with the car, in the next lane.
  Vehicle faster = moved(kCar, 0.3 * kCar.along_m, -3.0);
  faster.speed_mps *= 1.3;
  const VehicleEstimate beside = estimate_of(3, faster, Frames::all);
  EXPECT_FALSE(rides_on(beside, car, kOverLamps_m));
  EXPECT_FALSE(mirrors(car, beside, kOverLamps_m, kLampHeight_m));
  // In one line with it throughout, but in a lane.
  Vehicle beyond = kCar;
  beyond.speed_mps *= 1.4;
  beyond.along_m *= 1.4;
  beyond.lateral_m = 1.4 * (kCar.lateral_m - 0.6);
  Site site = mast_site(5.0);
  site.road.lanes.push_back({"middle", {beyond.lateral_m, 0.3}, 3.5, Direction::oncoming});
  const VehicleEstimate real = estimate_of(4, beyond, Frames::all, kLong, site);
  ASSERT_EQ(real.result.lane, "middle");
  EXPECT_FALSE(rides_on(real, car, kOverLamps_m));
  // Far faster than that, in line all the while: lamps on its roof.
  Vehicle far_faster = kCar;
  far_faster.speed_mps *= 1.7;
  far_faster.along_m *= 1.7;
  far_faster.lateral_m = 1.7 * (kCar.lateral_m - 0.5);
  site.road.lanes.push_back({"far", {far_faster.lateral_m, 0.3}, 3.5, Direction::oncoming});
  EXPECT_TRUE(rides_on(estimate_of(6, far_faster, Frames::all, kLong, site), car, kOverLamps_m));
  // Far fainter than headlamps are: markers on its roof.
  View faint = kLong;
  faint.flux_at_1m *= 0.1;
  EXPECT_TRUE(rides_on(estimate_of(5, beyond, Frames::all, faint, site), car, kOverLamps_m));
}

}  // namespace
}  // namespace vildar
