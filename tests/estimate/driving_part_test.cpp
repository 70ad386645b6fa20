#include "estimate/driving_part.h"

#include <cmath>

#include <gtest/gtest.h>

#include "estimate/vehicle.h"
#include "simulated_pass.h"

namespace vildar {
namespace {

using simulated::mast_site;
using simulated::track_of;
using simulated::Vehicle;
using simulated::View;

/// Drives 10 m/s from 75 to 45 m, brakes, stands 32.5 m off from 5.5 s on for `stands_s`, and goes
/// on to 7 m.
Vehicle stops_for(double stands_s) {
  return {.speed_mps = 10.0,
          .along_m = 75.0,
          .changes = {{3.0, -4.0}, {5.5, 4.0}, {5.5 + stands_s, 2.0}}};
}

VehicleTrack seen(const Vehicle& vehicle, const Site& site, double to_s, std::uint64_t seed = 1) {
  Random random(seed);
  View view{.to_s = to_s};
  return track_of(vehicle, site, view, random);
}

TEST(DrivingPart, IsThatOfTheLongestWay) {
  const Site site = mast_site(5.0);
  const Camera camera(*site.camera);
  const auto part = driving_part(seen(stops_for(3.0), site, 13.5), camera, site);
  ASSERT_TRUE(part);
  EXPECT_EQ(seconds_of(part->sightings.front().time), 0.0);
  EXPECT_NEAR(seconds_of(part->sightings.back().time), 5.1, 0.4);
  // It has hardly moved before it stops: what comes after is farther.
  Vehicle late = stops_for(3.0);
  late.along_m = 65.0;
  VehicleTrack track = seen(late, site, 12.5);
  std::erase_if(track.sightings, [](const auto& one) { return seconds_of(one.time) < 4.6; });
  const auto after = driving_part(track, camera, site);
  ASSERT_TRUE(after);
  EXPECT_GT(seconds_of(after->sightings.front().time), 8.5);
  EXPECT_EQ(after->sightings.back().frame, track.sightings.back().frame);
}

TEST(DrivingPart, WhoDrivesAllAlongOrCannotBeToldToStandIsLeftWhole) {
  const Site site = mast_site(5.0);
  const Camera camera(*site.camera);
  const Vehicle slows{.speed_mps = 10.0, .along_m = 75.0, .changes = {{3.0, -4.0}, {5.2, 6.0}}};
  EXPECT_FALSE(driving_part(seen(slows, site, 8.0), camera, site));
  EXPECT_FALSE(driving_part(seen({.speed_mps = 1.5, .along_m = 30.0}, site, 10.0), camera, site));
  EXPECT_FALSE(driving_part(seen({.speed_mps = 0.0, .along_m = 30.0}, site, 4.0), camera, site))
      << "no part in which it drives";
  const Site low = mast_site(1.2);
  EXPECT_FALSE(driving_part(seen(stops_for(3.0), low, 13.5), Camera(*low.camera), low));
  Site moving = site;
  moving.ego.emplace();
  EXPECT_FALSE(driving_part(seen(stops_for(3.0), site, 13.5), camera, moving));
}

// It had the speed of where it stops, or none.
TEST(DrivingPart, OfAVehicleThatWaitsTheSpeedIsThatOfItsDrive) {
  constexpr int kTrials = 40;
  const Site site = mast_site(5.0);
  double chi2 = 0.0;
  for (std::uint64_t seed = 1; seed <= kTrials; ++seed) {
    const Vehicle stops = stops_for(3.0);
    const auto result = estimate_vehicle(seen(stops, site, 13.5, seed), site, {}).result;
    ASSERT_FALSE(result.withheld) << name_of(*result.withheld);
    const double truth_mps = stops.speed_at_mps(result.speed.time_s);
    EXPECT_GT(truth_mps, 3.0);
    EXPECT_NEAR(result.speed.speed_mps, truth_mps, 3.5 * result.speed.std_mps) << seed;
    EXPECT_EQ(result.t_first_s, 0.0);
    EXPECT_GT(result.t_last_s, 13.0) << "seen all the while";
    chi2 += std::pow((result.speed.speed_mps - truth_mps) / result.speed.std_mps, 2);
  }
  EXPECT_LT(chi2 / kTrials, 2.0);
}

}  // namespace
}  // namespace vildar
