#include <cmath>

#include <gtest/gtest.h>

#include "estimate/hypotheses.h"
#include "estimate/metric_priors.h"
#include "estimate/mixture.h"
#include "estimate/vehicle.h"
#include "lamp_population.h"
#include "support/trials.h"

namespace vildar {
namespace {

using simulated::track_of;
using simulated::Vehicle;
using simulated::View;

constexpr double kTwoSided95 = 1.959963984540054;
constexpr View kFewFrames{.to_s = 2.2, .frame_rate_hz = 15.0, .sigma_px = 0.1};

VehicleResult result_of(const Vehicle& vehicle, const Site& site, const View& view) {
  Random random(1);
  return estimate_vehicle(track_of(vehicle, site, view, random), site, {}).result;
}

void expect_covered(const VehicleResult& result, const Vehicle& vehicle) {
  ASSERT_FALSE(result.withheld) << name_of(*result.withheld);
  const double truth_mps = std::abs(vehicle.speed_at_mps(result.speed.time_s));
  EXPECT_LE(result.speed.lo95_mps, truth_mps);
  EXPECT_GE(result.speed.hi95_mps, truth_mps);
}

TEST(Hypotheses, ALorryIsNotTakenForACar) {
  const Site site = simulated::mixed_site(4.0);
  // As a car of 1.25 m between the lamps it would do 13 m/s; its lane and height say otherwise.
  const Vehicle lorry{20.0, 0.0, 60.0, -4.0, 1.0, 2.0};
  const VehicleResult result = result_of(lorry, site, kFewFrames);
  expect_covered(result, lorry);
  EXPECT_LT(result.speed.std_mps, 0.05 * result.speed.speed_mps);
  EXPECT_TRUE(result.warnings.empty());
}

// Drives away from a mast on a road of cars, lorries and motorcycles.
VehicleResult receding_result(const Vehicle& vehicle, Site site, bool single_lamp = false) {
  site.road.lanes[0].direction = Direction::receding;
  Random random(1);
  View view = kFewFrames;
  view.single_lamp = single_lamp;
  VehicleTrack track = track_of(vehicle, site, view, random);
  track.kind = LampKind::taillamp;
  track.direction = Direction::receding;
  return estimate_vehicle(track, site, {}).result;
}

TEST(Hypotheses, ALorryThatDrivesAwayIsNotTakenForACar) {
  Site site = simulated::mixed_site(1.5);
  site.lamps.tail_height_m = Uncertain{0.8, 0.15};
  site.lamps.tail_separation_m = Uncertain{1.25, 0.2};
  Site told = site;
  told.lamps.classes[0].tail_separation_m = Uncertain{1.3, 0.15};
  told.lamps.classes[1].tail_height_m = Uncertain{0.95, 0.15};
  told.lamps.classes[1].tail_separation_m = Uncertain{2.05, 0.15};
  const Vehicle lorry{-20.0, 0.0, 12.0, -4.0, 1.0, 2.1};
  const Vehicle car{-20.0, 0.0, 12.0, -4.0, 0.85, 1.3};
  for (const Vehicle& vehicle : {lorry, car}) {
    const VehicleResult result = receding_result(vehicle, told);
    expect_covered(result, vehicle);
    EXPECT_LT(std::abs(result.speed.speed_mps - 20.0), 0.075 * 20.0);
  }
  const Vehicle motorcycle{-20.0, 0.0, 12.0, -3.5, 0.8, 0.0};
  expect_covered(receding_result(motorcycle, told, true), motorcycle);
  // One population for all that drive away, as long as no class has its own: a lorry is too slow.
  EXPECT_LT(receding_result(lorry, site).speed.speed_mps, 0.9 * 20.0);
}

TEST(Hypotheses, TailLampsOfAClassThatGivesNoneAreThoseOfAll) {
  LampsSite lamps = simulated::mixed_site(4.0).lamps;
  lamps.tail_height_m = Uncertain{0.8, 0.1};
  EXPECT_EQ(lamp_readings(lamps, LampKind::taillamp, true).size(), 1U);
  lamps.classes[1].tail_separation_m = Uncertain{2.05, 0.15};
  const auto pairs = lamp_readings(lamps, LampKind::taillamp, true);
  ASSERT_EQ(pairs.size(), 2U);  // a motorcycle has one
  for (const LampReading& one : pairs) EXPECT_EQ(one.height_m, lamps.tail_height_m);
  EXPECT_EQ(pairs[0].separation_m, (Uncertain{1.25, 0.2}));  // the headlamps', looser
  EXPECT_EQ(pairs[1].separation_m, (Uncertain{2.05, 0.15}));
  const auto singles = lamp_readings(lamps, LampKind::taillamp, false);
  ASSERT_EQ(singles.size(), 3U);
  EXPECT_FALSE(singles[2].separation_m);
  EXPECT_GT(singles[2].share / lamps.classes[2].share, singles[0].share / lamps.classes[0].share);
  // Headlamps are as they were.
  EXPECT_EQ(lamp_readings(lamps, LampKind::headlamp, true)[1].separation_m,
            lamps.classes[1].separation_m);
}

TEST(Hypotheses, AMotorcycleHasOneLampAndNoSeparation) {
  const Site site = simulated::mixed_site(4.0);
  const Vehicle motorcycle{20.0, 0.0, 60.0, -3.5, 0.85, 0.0};
  View view = kFewFrames;
  view.single_lamp = true;
  expect_covered(result_of(motorcycle, site, view), motorcycle);
}

TEST(Hypotheses, ALightAloneInNoLaneIsNoVehicle) {
  const Site site = simulated::mast_site(4.0);
  View view = kFewFrames;
  for (const bool single_lamp : {false, true}) {
    view.single_lamp = single_lamp;
    const Vehicle in_lane{20.0, 0.0, 60.0, -4.2, 0.65, 1.2};
    EXPECT_FALSE(result_of(in_lane, site, view).withheld);
    // Where a lamp would be on the line between road and verge, lit paint is as good a guess.
    const Vehicle beside{20.0, 0.0, 60.0, -6.0, 0.65, 1.2};
    const VehicleResult result = result_of(beside, site, view);
    EXPECT_EQ(result.withheld, single_lamp ? std::optional(Miss::not_on_road) : std::nullopt);
  }
  Site without_lanes = site;
  without_lanes.road.lanes.clear();
  EXPECT_FALSE(result_of({20.0, 0.0, 60.0, -6.0, 0.65, 1.2}, without_lanes, view).withheld);
}

// At lamp height the two marker lamps, 3.4 m up in the lane, would be 1.2 m apart, 1.9 times as
// far, as fast and as far aside: 4.7 m, on the edge of the lane.
TEST(Hypotheses, APairBesideTheLanesThatMayRideOnARoofInOneIsNone) {
  constexpr double kTimes = (6.5 - 0.65) / (6.5 - 3.4);
  const Vehicle on_roof{15.0, 0.0, 60.0, -2.5, 3.4, 1.2 / kTimes};
  Site site = simulated::mast_site(6.5);
  site.road.lanes = {{"in", {-2.5, 0.3}, 3.5, Direction::oncoming}};
  EXPECT_EQ(result_of(on_roof, site, kFewFrames).withheld, Miss::not_on_road);
  // In a lane where it seems to be, it may be what it seems, with the speed of that.
  site.road.lanes.push_back({"out", {-2.5 * kTimes, 0.3}, 3.5, Direction::oncoming});
  const VehicleResult seems = result_of(on_roof, site, kFewFrames);
  ASSERT_FALSE(seems.withheld);
  EXPECT_NEAR(seems.speed.speed_mps, kTimes * 15.0, 2.0 * seems.speed.std_mps);
  // Between lanes, or in one of the other way.
  site.road.lanes = {{"in", {-2.5, 0.3}, 3.5, Direction::oncoming},
                     {"out", {-7.0, 0.3}, 3.5, Direction::oncoming}};
  EXPECT_NE(result_of(on_roof, site, kFewFrames).withheld, Miss::not_on_road);
  site.road.lanes[1] = {"back", {-4.7, 0.3}, 3.5, Direction::receding};
  EXPECT_NE(result_of(on_roof, site, kFewFrames).withheld, Miss::not_on_road);
  // Who has two lanes of his own does not overtake there.
  site.road.lanes.push_back({"second", {1.0, 0.3}, 3.5, Direction::oncoming});
  EXPECT_EQ(result_of(on_roof, site, kFewFrames).withheld, Miss::not_on_road);
  // Where there may be a lane that the site does not tell of.
  site.road.lanes = {{"next", {-1.4, 0.3}, 3.5, Direction::oncoming}};
  EXPECT_NE(result_of(on_roof, site, kFewFrames).withheld, Miss::not_on_road);
}

// The outer lamps of a light bar, 1.6 m up on a car: 1.2 times as far aside, between two lanes.
TEST(Hypotheses, ARowOfLightsInNoLaneIsOnARoof) {
  Site site = simulated::mast_site(6.5);
  site.road.lanes = {{"in", {-5.0, 0.3}, 3.5, Direction::oncoming},
                     {"out", {-8.5, 0.3}, 3.5, Direction::oncoming}};
  Random random(1);
  VehicleTrack bar = track_of({15.0, 0.0, 60.0, -5.2, 1.6, 1.1}, site, kFewFrames, random);
  EXPECT_FALSE(estimate_vehicle(bar, site, {}).result.withheld);
  bar.lights_between = true;
  EXPECT_EQ(estimate_vehicle(bar, site, {}).result.withheld, Miss::not_on_road);
  VehicleTrack car = track_of({15.0, 0.0, 60.0, -5.0, 0.65, 1.2}, site, kFewFrames, random);
  car.lights_between = true;
  EXPECT_FALSE(estimate_vehicle(car, site, {}).result.withheld);
}

TEST(Hypotheses, ClassesThatCannotBeToldApartBothLieInTheInterval) {
  // One lamp, no lane: nothing but its height, which is 0.5 m or 1.2 m, says how far it is.
  Site site = simulated::mixed_site(4.0);
  site.road.lanes.clear();
  site.lamps.classes = {{"low", 1.0, {0.5, 0.05}, {}}, {"high", 1.0, {1.2, 0.05}, {}}};
  View view = kFewFrames;
  view.single_lamp = true;
  for (const double height_m : {0.5, 1.2}) {
    const Vehicle vehicle{20.0, 0.0, 60.0, -4.0, height_m, 0.0};
    const VehicleResult result = result_of(vehicle, site, view);
    expect_covered(result, vehicle);
    // The other reading: speeds go as the camera's height over the lamps.
    const double other_mps = 20.0 * (4.0 - (1.7 - height_m)) / (4.0 - height_m);
    EXPECT_LE(result.speed.lo95_mps, other_mps);
    EXPECT_GE(result.speed.hi95_mps, other_mps);
    ASSERT_EQ(result.warnings.size(), 1U);
    EXPECT_NE(result.warnings[0].find("high"), std::string::npos);
  }
}

TEST(Hypotheses, LanesThatCannotBeToldApartBothLieInTheInterval) {
  // Nothing but the lane says how far a lamp is whose height is unknown; half way between the two
  // lanes in the bearings, which leaves 2.8 and 4.2 m equally likely.
  Site site = simulated::mixed_site(4.0);
  site.lamps = {};
  site.lamps.height_m = Uncertain{0.65, 0.6};
  site.road.lanes = {{"inner", {-2.8, 0.1}, 2.0, Direction::oncoming},
                     {"outer", {-4.2, 0.1}, 2.0, Direction::oncoming}};
  for (const double lateral_m : {-2.8, -4.2}) {
    const Vehicle vehicle{20.0, 0.0, 60.0, lateral_m, 0.65 + 3.35 * (1.0 + lateral_m / 3.5), 1.2};
    const VehicleResult result = result_of(vehicle, site, kFewFrames);
    expect_covered(result, vehicle);
    const double other_mps = 20.0 * (7.0 + lateral_m) / -lateral_m;
    EXPECT_LE(result.speed.lo95_mps, other_mps);
    EXPECT_GE(result.speed.hi95_mps, other_mps);
    EXPECT_EQ(result.lane, "");
  }
}

Trajectory known_speed(double weight, double speed_mps, double log_std) {
  Trajectory one;
  one.weight = weight;
  one.fit.parameters[kLogScale] = std::log(50.0);
  one.fit.parameters[kClosingRate] = speed_mps / 50.0;
  one.fit.covariance(kLogScale, kLogScale) = log_std * log_std;
  return one;
}

// Little below a camera that is tilted as nobody knows, one that leaves slowly: its range is one
// over an elevation, and far above the likeliest where the tilt is low.
TEST(Hypotheses, ALoneLampAheadMayBeFarFartherThanItsLikeliestRange) {
  constexpr int kTrials = trials(80);
  constexpr double kOwn_mps = 26.0, kLeaves_mps = 0.7, kPitch_rad = 0.0175;
  Site told = simulated::mast_site(1.35);
  told.camera->pitch_rad = {0.0, kPitch_rad};
  told.road.lanes = {{"own", {0.0, 0.3}, 3.5, Direction::receding}};
  told.lamps.tail_height_m = Uncertain{0.8, 0.15};
  told.lamps.tail_separation_m = Uncertain{1.3, 0.15};
  told.ego = EgoSite{{kOwn_mps, 0.05}, {}, {}};
  simulated::View view{.to_s = 3.4, .single_lamp = true};
  view.ego_mps = kOwn_mps;
  Random random(15);
  int measured = 0, inside = 0;
  for (int i = 0; i < kTrials; ++i) {
    Site truth = told;
    truth.camera->pitch_rad.mean = random.normal(0.0, kPitch_rad);
    simulated::Vehicle ahead;
    ahead.speed_mps = -(kOwn_mps + kLeaves_mps);
    ahead.along_m = random.uniform(20.0, 40.0);
    ahead.lateral_m = 0.0;
    ahead.height_m = random.normal(0.8, 0.15);
    VehicleTrack track = simulated::track_of(ahead, truth, view, random);
    track.direction = Direction::receding;
    track.kind = LampKind::taillamp;
    const VehicleResult result = estimate_vehicle(track, told, {}).result;
    if (result.withheld) continue;
    ++measured;
    inside += result.speed.lo95_mps <= kOwn_mps + kLeaves_mps &&
              kOwn_mps + kLeaves_mps <= result.speed.hi95_mps;
  }
  ASSERT_GE(measured, kTrials / 2);
  EXPECT_GE(inside, 0.95 * measured - 3.0 * std::sqrt(0.95 * 0.05 * measured));
}

TEST(Weigh, LeavesOutWhatHasNoEvidence) {
  Trajectory sound = known_speed(1.0, 20.0, 0.03);
  sound.fit.covariance = 1e-4 * PathMatrix::Identity();
  Trajectory broken = sound;
  broken.fit.covariance(kLateral, kLateral) = NAN;
  std::vector<Trajectory> trajectories{broken, sound, sound};
  weigh(trajectories);
  ASSERT_EQ(trajectories.size(), 2U);
  EXPECT_DOUBLE_EQ(trajectories.front().weight, 0.5);
  trajectories = {broken, broken};
  weigh(trajectories);
  EXPECT_TRUE(trajectories.empty());
}

TEST(Mixture, OfOneIsThatOne) {
  const std::vector<Trajectory> one{known_speed(1.0, 20.0, 0.03)};
  const SpeedEstimate speed = mixed_speed(one, 0.0);
  EXPECT_DOUBLE_EQ(speed.speed_mps, 20.0);
  EXPECT_NEAR(speed.hi95_mps, 20.0 * std::exp(0.03 * kTwoSided95), 1e-9);
}

TEST(Mixture, HasTheMomentsAndQuantilesOfItsParts) {
  // Far apart and equally likely: each tail of 2.5 % is one of 5 % of its own part.
  constexpr double kOneSided95 = 1.6448536269514722;
  const std::vector<Trajectory> two{known_speed(0.5, 30.0, 0.01), known_speed(0.5, 20.0, 0.01)};
  const SpeedEstimate speed = mixed_speed(two, 0.0);
  EXPECT_NEAR(speed.speed_mps, 25.0, 1e-9);
  EXPECT_NEAR(speed.std_mps, std::sqrt(25.0 + 0.5 * (0.3 * 0.3 + 0.2 * 0.2)), 1e-9);
  EXPECT_NEAR(speed.lo95_mps, 20.0 * std::exp(-0.01 * kOneSided95), 1e-6);
  EXPECT_NEAR(speed.hi95_mps, 30.0 * std::exp(0.01 * kOneSided95), 1e-6);
}

}  // namespace
}  // namespace vildar
