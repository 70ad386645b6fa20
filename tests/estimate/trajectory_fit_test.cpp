#include <cmath>

#include <gtest/gtest.h>

#include "core/clock.h"
#include "estimate/vehicle.h"
#include "simulated_pass.h"
#include "support/trials.h"

namespace vildar {
namespace {

constexpr simulated::View kMovingView{.to_s = 2.4, .sigma_px = 0.1};

// All lengths known, so that what is left is how the vehicle moves.
Site surveyed() {
  Site site = simulated::mast_site(5.0);
  site.lamps.height_m = Uncertain{0.65, 0.005};
  return site;
}

constexpr simulated::Vehicle kCruising{20.0, 0.0, 60.0, -4.0, 0.65, 1.2};

void expect_right(const VehicleResult& result, const simulated::Vehicle& vehicle) {
  ASSERT_FALSE(result.withheld) << name_of(*result.withheld);
  constexpr double kSigmas = 3.5;  // one in two thousand
  const double truth_mps = vehicle.speed_at_mps(result.speed.time_s);
  EXPECT_NEAR(result.speed.speed_mps, truth_mps, kSigmas * result.speed.std_mps);
}

TEST(TrajectoryFit, AMotionAsTheModelSaysIsMeasuredWhole) {
  Random random(1);
  const Site site = surveyed();
  const VehicleEstimate estimate =
      estimate_vehicle(simulated::track_of(kCruising, site, kMovingView, random), site, {});
  expect_right(estimate.result, kCruising);
  EXPECT_TRUE(estimate.result.warnings.empty());
  for (const TrackRow& row : estimate.rows) EXPECT_TRUE(row.range_m);
}

TEST(TrajectoryFit, ALampThatIsAnothersForAWhileIsLeftOut) {
  Random random(1);
  const Site site = surveyed();
  VehicleTrack track = simulated::track_of(kCruising, site, kMovingView, random);
  // The right lamp is hidden behind the car ahead, whose own lamp is taken for it.
  constexpr double kHidden_s = 1.0;
  for (VehicleSighting& sighting : track.sightings) {
    const double t_s = seconds_of(sighting.time);
    if (t_s < kHidden_s) sighting.right->centre_px += Eigen::Vector2d(40.0 + 60.0 * t_s, 25.0);
  }
  const VehicleEstimate estimate = estimate_vehicle(track, site, {});
  expect_right(estimate.result, kCruising);
  ASSERT_EQ(estimate.result.warnings.size(), 1U);
  EXPECT_FALSE(estimate.rows.front().range_m);
  ASSERT_TRUE(estimate.rows.back().range_m);
  EXPECT_NEAR(*estimate.rows.back().range_m, kCruising.along_at_m(estimate.rows.back().time_s),
              0.2);
}

// A wet road that it lights draws one lamp aside for its last frames.
TEST(TrajectoryFit, ALampDrawnAsideForAWhileDoesNotPull) {
  constexpr simulated::Vehicle kFar{17.0, 0.0, 110.0, -4.0, 0.65, 1.2};
  constexpr double kFrom_s = 2.0;
  const Site site = surveyed();
  for (const double off_px : {0.7, 1.0, 2.0, 3.0})
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
      Random random(seed);
      VehicleTrack track = simulated::track_of(kFar, site, kMovingView, random);
      for (VehicleSighting& sighting : track.sightings)
        if (seconds_of(sighting.time) > kFrom_s)
          sighting.right->centre_px += Eigen::Vector2d::Constant(off_px);
      expect_right(estimate_vehicle(track, site, {}).result, kFar);
    }
}

TEST(TrajectoryFit, AFarLampThatIsBlendedWithAFollowersGivesNoWrongSpeed) {
  // First one lamp alone, then the other with a lamp of the vehicle behind in it, until the vehicle
  // is near: what is seen far off makes a steady path of its own.
  constexpr simulated::Vehicle kFromFar{36.0, 0.0, 155.0, -4.0, 0.65, 1.2};
  constexpr simulated::View kLong{.to_s = 4.0, .sigma_px = 0.1};
  constexpr double kBoth_s = 1.0;
  // The lengths are what the site expects on average: what is off is of the shape alone.
  constexpr double kMostSigmas = 3.5, kMostShape = 0.02;
  const Site site = simulated::mast_site(1.3);
  for (const double off_px : {-2.0, 2.5})
    for (const double parted_s : {2.3, 2.5, 2.7}) {
      Random random(1);
      VehicleTrack track = simulated::track_of(kFromFar, site, kLong, random);
      for (VehicleSighting& sighting : track.sightings) {
        const double t_s = seconds_of(sighting.time);
        if (t_s < parted_s) sighting.right->centre_px.x() += off_px;
        if (t_s < kBoth_s) sighting.right.reset();
      }
      const VehicleResult result = estimate_vehicle(track, site, {}).result;
      if (result.withheld) continue;
      EXPECT_LT(result.budget->shape, kMostShape);
      EXPECT_NEAR(result.speed.speed_mps, kFromFar.speed_at_mps(result.speed.time_s),
                  kMostSigmas * result.budget->shape * result.speed.speed_mps);
    }
}

TEST(TrajectoryFit, ALoneLightBeforeThePairIsNotMeasuredInItsPlace) {
  // Another vehicle's lamp, ahead by as much time as it takes to drive 30 m, twice as fast.
  constexpr double kPair_s = 1.7;
  constexpr simulated::Vehicle kOther{40.0, 0.0, 90.0, -4.0, 0.65, 1.2};
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    Random random(seed);
    const Site site = surveyed();
    VehicleTrack track = simulated::track_of(kCruising, site, kMovingView, random);
    const VehicleTrack other = simulated::track_of(kOther, site, kMovingView, random);
    for (std::size_t i = 0; i < track.sightings.size(); ++i)
      if (seconds_of(track.sightings[i].time) < kPair_s) {
        track.sightings[i].left = other.sightings[i].left;
        track.sightings[i].right.reset();
      }
    const VehicleResult result = estimate_vehicle(track, site, {}).result;
    if (!result.withheld) expect_right(result, kCruising);
  }
}

// One lamp of a vehicle in traffic, until it is near.
constexpr simulated::Vehicle kInTraffic{9.8, 0.0, 92.0, -4.0, 0.65, 1.2};
constexpr simulated::View kLongView{.to_s = 3.3, .sigma_px = 0.3};

VehicleTrack showing_one_lamp(const Site& site, double until_s, bool left, std::uint64_t seed) {
  Random random(seed);
  VehicleTrack track = simulated::track_of(kInTraffic, site, kLongView, random);
  for (VehicleSighting& sighting : track.sightings)
    if (seconds_of(sighting.time) < until_s) (left ? sighting.right : sighting.left).reset();
  return track;
}

TEST(TrajectoryFit, OneLampIsNotTakenForTheMiddleOfBoth) {
  constexpr double kMostOff = 0.04;
  const Site site = simulated::mast_site(5.0);
  for (const double both_s : {0.08, 0.5, 1.2})  // 3, 16 and 37 of 100 frames show both
    for (const bool left : {true, false})
      for (const std::uint64_t seed : {1U, 2U, 3U}) {
        const VehicleTrack track = showing_one_lamp(site, kLongView.to_s - both_s, left, seed);
        const VehicleResult result = estimate_vehicle(track, site, {}).result;
        expect_right(result, kInTraffic);
        if (result.withheld) continue;
        EXPECT_NEAR(result.speed.speed_mps, kInTraffic.speed_mps, kMostOff * kInTraffic.speed_mps)
            << both_s << " s, left " << left;
      }
}

TEST(TrajectoryFit, ABlobThatHoldsBothLampsStandsForTheirMiddle) {
  constexpr double kMostOff = 0.04, kParted_s = 2.6;
  const Site site = simulated::mast_site(5.0);
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    VehicleTrack track = showing_one_lamp(site, 0.0, true, seed);
    for (VehicleSighting& sighting : track.sightings) {
      if (seconds_of(sighting.time) > kParted_s) continue;
      const Eigen::Vector2d apart_px = sighting.left->centre_px - sighting.right->centre_px;
      sighting.left->centre_px -= 0.5 * apart_px;
      sighting.left->centre_sigma_px.setConstant(1.0);
      sighting.right.reset();
      sighting.both_in_one = true;
    }
    const VehicleResult result = estimate_vehicle(track, site, {}).result;
    expect_right(result, kInTraffic);
    if (result.withheld) continue;
    EXPECT_NEAR(result.speed.speed_mps, kInTraffic.speed_mps, kMostOff * kInTraffic.speed_mps);
  }
}

// The left lamp is the vehicle's; of the lights beside it that are taken for its right one in turn,
// another's was the first.
TEST(TrajectoryFit, LampsThatAreNotOneVehiclesDenyEachOther) {
  const Site site = simulated::mast_site(5.0);
  constexpr simulated::Vehicle kOther{15.0, 0.0, 92.0, -4.0, 0.65, 1.2};
  Random random(4);
  const VehicleTrack other = simulated::track_of(kOther, site, kLongView, random);
  VehicleTrack track = showing_one_lamp(site, 2.7, true, 1);
  for (std::size_t i = 0; i < track.sightings.size(); ++i)
    if (i % 3 == 0 && seconds_of(track.sightings[i].time) < 2.7) {
      track.sightings[i].left.reset();
      track.sightings[i].right = other.sightings[i].right;
    }
  const VehicleResult result = estimate_vehicle(track, site, {}).result;
  if (!result.withheld) expect_right(result, kInTraffic);
}

// Far off, one lamp shows of each of two cars that follow one another: the nearer one is seen
// lower, by some 7 degrees of the line through both where the farther car's lamps stand lower.
TEST(TrajectoryFit, FarLampsOfTwoCarsBeforeAMastAreNoVehicle) {
  constexpr simulated::View kFarView{.to_s = 1.2, .sigma_px = 0.1};
  Site site = simulated::mast_site(6.4);
  site.road.lanes[0].lateral_m.mean = 8.0;
  for (Uncertain* turn_rad :
       {&site.camera->yaw_rad, &site.camera->pitch_rad, &site.camera->roll_rad})
    turn_rad->std = 0.0026;
  int ambiguous = 0;
  for (const double along_m : {120.0, 150.0, 180.0})
    for (const double gap_m : {9.0, 12.0, 15.0}) {
      const simulated::Vehicle ahead{16.0, 0.0, along_m, 8.0, 0.65, 1.2};
      simulated::Vehicle behind = ahead;
      behind.along_m += gap_m;
      behind.lateral_m -= 0.4;
      behind.height_m -= 0.2;
      Random random(7);
      const VehicleResult result =
          estimate_vehicle(
              simulated::right_lamps_of(simulated::track_of(ahead, site, kFarView, random),
                                        simulated::track_of(behind, site, kFarView, random)),
              site, {})
              .result;
      EXPECT_TRUE(result.withheld)
          << along_m << " m, " << gap_m << " m apart: " << result.speed.speed_mps << " +- "
          << result.speed.std_mps;
      ambiguous += result.withheld == Miss::ambiguous_identity;
    }
  EXPECT_EQ(ambiguous, 9);
}

// Of a queue before a low camera, as the gap closes and the nearer comes by, their line turns.
TEST(TrajectoryFit, ALineOfLampsThatTurnsIsNoVehicle) {
  constexpr simulated::View kQueueView{.to_s = 4.0, .sigma_px = 0.1};
  Site site = simulated::mast_site(1.55);
  site.road.lanes[0].lateral_m.mean = 7.5;
  site.camera->position_m[2].std = 0.05;
  site.lamps.height_m = Uncertain{0.68, 0.08};
  site.lamps.separation_m = Uncertain{1.25, 0.12};
  site.camera->yaw_rad.std = radians_from_degrees(5.0);
  site.camera->pitch_rad.std = radians_from_degrees(4.0);
  site.camera->roll_rad.std = radians_from_degrees(1.0);
  Random random(7);
  int measured = 0;  // 7 of 300 where no turn counts, 3 where it does
  for (int trial = 0; trial < trials(30); ++trial) {
    const simulated::Vehicle ahead{9.0 + 2.0 * random.uniform(),   random.normal(0.0, 0.4),
                                   80.0 + 40.0 * random.uniform(), random.normal(7.4, 0.2),
                                   random.normal(0.68, 0.08),      random.normal(1.25, 0.1)};
    const simulated::Vehicle behind{7.0 + 4.0 * random.uniform(),
                                    random.normal(0.0, 0.4),
                                    ahead.along_m + 8.0 + 12.0 * random.uniform(),
                                    random.normal(7.4, 0.2),
                                    random.normal(0.68, 0.08),
                                    random.normal(1.25, 0.1)};
    const VehicleResult result =
        estimate_vehicle(
            simulated::right_lamps_of(simulated::track_of(ahead, site, kQueueView, random),
                                      simulated::track_of(behind, site, kQueueView, random)),
            site, {})
            .result;
    measured += !result.withheld;
  }
  EXPECT_EQ(measured, 0);
}

// From 15 m/s to a stop in 3.6 s, and it stands: parts of the track before, in and after it are of
// one vehicle.
TEST(TrajectoryFit, OneThatBrakesToAStopIsOneVehicle) {
  const Site site = simulated::mast_site(1.5);
  int measured = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Random random(seed);
    const double brakes_mps2 = random.uniform(3.5, 5.0), from_s = random.uniform(1.0, 1.6);
    simulated::Vehicle car{.speed_mps = 15.0, .along_m = 64.0};
    const double stops_s = from_s + 15.0 / brakes_mps2;
    car.changes = {{from_s, -brakes_mps2}, {stops_s, brakes_mps2}};
    const VehicleResult result =
        estimate_vehicle(simulated::track_of(car, site, {.to_s = 7.0, .sigma_px = 0.05}, random),
                         site, {})
            .result;
    if (result.withheld) continue;
    ++measured;
    EXPECT_LT(std::abs(result.speed.speed_mps - car.speed_at_mps(result.speed.time_s)),
              3.0 * result.speed.std_mps)
        << seed;
  }
  EXPECT_EQ(measured, 10);
}

TEST(TrajectoryFit, ABrakingThatBeginsInViewIsFollowed) {
  constexpr double kOnset_s = 0.16;  // between two steps of the fitted acceleration
  const Site site = surveyed();
  for (const double change_s : {0.6, 1.2, 1.6}) {
    simulated::Vehicle braking = kCruising;
    braking.changes = {{change_s, -5.0}};
    Random random(1);
    const VehicleEstimate estimate =
        estimate_vehicle(simulated::track_of(braking, site, kMovingView, random), site, {});
    expect_right(estimate.result, braking);
    for (const TrackRow& row : estimate.rows) {
      ASSERT_TRUE(row.speed_mps) << change_s;
      if (std::abs(row.time_s - change_s) < kOnset_s) continue;
      EXPECT_NEAR(*row.speed_mps, braking.speed_at_mps(row.time_s), 4.5 * *row.speed_std_mps)
          << change_s << " at " << row.time_s;
    }
  }
}

}  // namespace
}  // namespace vildar
