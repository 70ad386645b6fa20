#include <gtest/gtest.h>

#include "made_scenes.h"

namespace vildar {
namespace {

using scene::car;
using scene::Car;
using scene::dashcam;
using scene::expect_each_car_once;
using scene::mast;
using scene::Scene;
using scene::tower;

TEST(TrackScene, MastSeesBothDirectionsAndNoStreetLamps) {
  Scene made = mast();
  made.cars = {car(90, -4, -15), car(120, -4, -17), car(20, -7.5, 14, LampKind::taillamp)};
  made.street_lamps = {{60, 6, 8}, {95, 6, 8}, {60, -11, 8}};
  made.clutter_per_frame = 0.5;
  made.duration_s = 6.0;
  const auto outcome = scene::run(made);
  expect_each_car_once(outcome, 3, 0.9);
  for (std::size_t i = 0; i < outcome.tracks.size(); ++i) {
    const VehicleTrack& track = outcome.tracks[i];
    const bool tail = outcome.car_of(i) == 2;
    EXPECT_EQ(track.kind, tail ? LampKind::taillamp : LampKind::headlamp);
    EXPECT_EQ(track.direction, tail ? Direction::receding : Direction::oncoming);
    EXPECT_FALSE(track.single_lamp || track.ambiguous_identity || track.direction_contradicts);
  }
  EXPECT_EQ(outcome.counts.static_lights, 3);
  EXPECT_GT(outcome.kinds_of_street_blobs.at(LampKind::street), 300);
}

TEST(TrackScene, SightingsNameLeftAndRightAsSeen) {
  Scene made = mast();
  made.cars = {car(80, -4, -15)};
  const auto outcome = scene::run(made);
  ASSERT_EQ(outcome.tracks.size(), 1U);
  int both = 0;
  std::int64_t last = -1;
  for (const VehicleSighting& sighting : outcome.tracks[0].sightings) {
    EXPECT_GT(sighting.frame, last);
    last = sighting.frame;
    if (!sighting.left || !sighting.right) continue;
    ++both;
    EXPECT_LT(sighting.left->centre_px.x(), sighting.right->centre_px.x());
  }
  EXPECT_GT(both, 80);
}

TEST(TrackScene, WetRoadMirrorImagesAreNotVehicles) {
  for (const bool low : {false, true}) {
    Scene made = low ? dashcam(12.0) : mast();
    made.wet = true;
    made.cars = {car(100, 3.6, -14), car(140, 3.6, -14)};
    made.duration_s = 4.0;
    const auto outcome = scene::run(made);
    expect_each_car_once(outcome, 2, 0.8);
    EXPECT_GE(outcome.counts.reflections, 3) << (low ? "dashcam" : "mast");
    EXPECT_GT(outcome.kinds_of_mirror_blobs.at(LampKind::reflection), 80);
  }
}

TEST(TrackScene, EndsOfLongStreaksOnTheRoadAreNotVehicles) {
  for (const double heights : {3.1, 3.8}) {
    Scene made = mast();
    made.wet = true;
    made.image_heights = heights;
    made.cars = {car(70, 3.6, -14), car(110, 3.6, -14)};
    const auto outcome = scene::run(made);
    EXPECT_EQ(outcome.tracks.size(), 2U) << heights << " lamp heights below";
    expect_each_car_once(outcome, 2, 0.8);
  }
}

TEST(TrackScene, ShakingViewOfATwentyCarQueue) {
  Scene made = tower();
  made.shake_px = 2.0;
  for (int i = 0; i < 20; ++i) {
    Car one = car(60.0 + 9.0 * (i / 2), i % 2 ? -3.5 : 0.0, -8.0);
    one.stops_at_s = 2.0;
    one.starts_again_s = 5.0;
    made.cars.push_back(one);
  }
  made.duration_s = 9.0;
  const auto outcome = scene::run(made);
  int pure = 0;
  for (std::size_t i = 0; i < outcome.tracks.size(); ++i)
    pure += outcome.car_of(i).has_value() || outcome.tracks[i].ambiguous_identity;
  EXPECT_EQ(pure, static_cast<int>(outcome.tracks.size()));
  int once = 0;
  for (int c = 0; c < 20; ++c) once += outcome.tracks_of(c) == 1 && outcome.recall(c) > 0.8;
  EXPECT_GE(once, 19);
}

TEST(TrackScene, SurvivesHalfASecondOutOfSight) {
  Scene made = mast();
  made.cars = {car(80, -4, -15), car(110, -7.5, -15)};
  made.cars[0].hidden_s = {{1.5, 2.0}};
  const auto outcome = scene::run(made);
  expect_each_car_once(outcome, 2, 0.9);
}

TEST(TrackScene, ComesOutFromBehindAnotherVehicleAsItself) {
  for (const double hidden_s : {1.0, 1.3, 1.6}) {
    Scene made = mast();
    made.cars = {car(90, -4, -12), car(110, -7.5, -15), car(125, -4, -12)};
    made.cars[0].hidden_s = {{1.5, 1.5 + hidden_s}};
    made.duration_s = 6.0;
    expect_each_car_once(scene::run(made), 3, 0.9);
  }
}

TEST(TrackScene, ComesOutFromBehindAnotherVehicleBeforeADashcam) {
  for (const double hidden_s : {0.8, 1.1, 1.4}) {
    Scene made = dashcam(14.0);
    made.cars = {car(70, 3.6, -4), car(130, 3.6, -4)};
    made.cars[0].hidden_s = {{1.2, 1.2 + hidden_s}};
    expect_each_car_once(scene::run(made), 2, 0.9);
  }
}

TEST(TrackScene, HeadingKnownToAFewDegreesOnly) {
  for (const double off_deg : {-3.0, 3.0}) {
    Scene made = mast();
    made.site.road.lanes = {{"near", {-4.0, 0.0}, 3.5, Direction::oncoming}};
    made.told = made.site;
    made.told->camera->yaw_rad = {radians_from_degrees(off_deg), radians_from_degrees(3.0)};
    made.cars = {car(95, -4, -15), car(130, -4, -17)};
    made.duration_s = 6.0;
    expect_each_car_once(scene::run(made), 2, 0.9);
  }
}

TEST(TrackScene, FogLampsBelowTheHeadlampsAreNoSecondVehicle) {
  for (const double power : {0.3, 0.8, 1.3}) {
    Scene made = mast();
    made.cars = {car(100, -4, -15), car(100, -4, -15)};
    made.cars[1].height_m = made.cars[0].height_m - 0.33;
    made.cars[1].separation_m = 1.1;
    made.cars[1].power = power;
    made.duration_s = 6.0;
    const auto outcome = scene::run(made);
    ASSERT_EQ(outcome.tracks.size(), 1U) << power;
    EXPECT_EQ(outcome.tracks_of(0), 1) << power;
  }
}

TEST(TrackScene, TwoCarsAbreastWithEqualGapsPairRightly) {
  for (const double y_m : {-4.0, 0.0, 3.0}) {
    Scene made = mast();
    made.cars = {car(80, y_m, -14), car(80, y_m - 2.5, -14)};
    expect_each_car_once(scene::run(made), 2, 0.85);
  }
}

TEST(TrackScene, LorryBehindACar) {
  Scene made = mast();
  made.cars = {car(70, -4, -12), car(82, -4, -12)};
  made.cars[1].separation_m = 2.05;
  made.cars[1].height_m = 0.85;
  expect_each_car_once(scene::run(made), 2, 0.85);
}

TEST(TrackScene, MotorcycleThatWaitsForMinutesIsStillReported) {
  Scene made = mast();
  made.site = scene::site_of(5.0, -4.0, 1400.0, 1920, 1080);
  made.miss_share = 0.0;
  made.cars = {car(70, -4, -10)};
  made.cars[0].single = true;
  made.cars[0].stops_at_s = 1.5;
  made.cars[0].starts_again_s = 301.5;
  made.duration_s = 306.0;
  const auto outcome = scene::run(made);
  ASSERT_EQ(outcome.tracks.size(), 1u);
  EXPECT_TRUE(outcome.tracks[0].single_lamp);
}

TEST(TrackScene, MotorcycleIsASingleLamp) {
  Scene made = mast();
  made.cars = {car(70, -4, -14), car(95, -4, -14)};
  made.cars[0].single = true;
  const auto outcome = scene::run(made);
  expect_each_car_once(outcome, 2, 0.85);
  for (std::size_t i = 0; i < outcome.tracks.size(); ++i)
    EXPECT_EQ(outcome.tracks[i].single_lamp, outcome.car_of(i) == 0);
}

// It keeps in line with a place 4.5 m before the car's tail lamps and 0.8 m over them, where its
// body would hide a light.
TEST(TrackScene, AFasterMotorcycleInLineWithACarThatDrivesAwayIsNoLightOnIt) {
  constexpr double kFarther = 1.4;
  Scene made = mast();
  made.site = scene::site_of(3.5, -5.0, 800.0, 1280, 720);
  made.site.camera->yaw_rad.mean = radians_from_degrees(-8.0);
  made.cars = {
      car(8.0, -11.0, 10.5, LampKind::taillamp),
      car(kFarther * (8.0 + 4.5), kFarther * (-11.0 + 0.8), kFarther * 10.5, LampKind::taillamp)};
  made.cars[1].single = true;
  expect_each_car_once(scene::run(made), 2, 0.85);
}

// The only headlamp among tail lamps is fifty times as strong as they are.
TEST(TrackScene, AMotorcycleThatComesAmongCarsThatDriveAwayIsALamp) {
  Scene made = mast();
  for (int i = 0; i < 5; ++i)
    made.cars.push_back(car(20.0 + 14.0 * i, -10.0 - 3.5 * (i % 2), 10.0, LampKind::taillamp));
  for (Car& ahead : made.cars) ahead.power = 0.02;
  made.cars.push_back(car(100.0, -4.0, -14.0));
  made.cars.back().single = true;
  made.duration_s = 6.0;
  expect_each_car_once(scene::run(made), 6, 0.85);
}

TEST(TrackScene, FarPairSplitsOutOfOneBlob) {
  Scene made = tower();  // 600 px: the pair is under 4 px apart beyond 190 m
  made.site = scene::site_of(6.0, -1.0, 600.0, 640, 360);
  made.resolution_px = 6.0;
  made.cars = {car(180, -4, -20)};
  made.duration_s = 7.0;
  const auto outcome = scene::run(made);
  expect_each_car_once(outcome, 1, 0.85);
  int marked = 0, both = 0;
  for (const VehicleSighting& sighting : outcome.tracks[0].sightings) {
    both += sighting.left && sighting.right;
    if (!sighting.left || !has(sighting.left->defects, Defect::merged)) continue;
    ++marked;
    EXPECT_FALSE(sighting.right);
    EXPECT_GT(sighting.left->centre_sigma_px.x(), 1.0);  // half of some 6 px, at least
  }
  EXPECT_GT(marked, 40);  // from 180 m to 125 m at 20 m/s: 68 frames
  EXPECT_GT(both, 60);
}

TEST(TrackScene, NoHandOverFromHeadlampsToTaillamps) {
  Scene made = mast();
  made.cars = {car(60, -4, -12), car(36, -4, 12, LampKind::taillamp)};
  made.cars[0].hidden_s = {{2.0, 9.0}};
  made.cars[1].x_m = 36.0 - 2.0 * 12.0;  // where the other one vanishes, at that time
  made.cars[1].hidden_s = {{0.0, 2.0}};
  const auto outcome = scene::run(made);
  expect_each_car_once(outcome, 2, 0.85);
}

TEST(TrackScene, MotionAgainstTheColourIsMarked) {
  Scene made = mast();
  made.cars = {car(25, -4, 12), car(90, -7.5, -12, LampKind::taillamp)};
  const auto outcome = scene::run(made);
  ASSERT_EQ(outcome.tracks.size(), 2U);
  for (const VehicleTrack& track : outcome.tracks) EXPECT_TRUE(track.direction_contradicts);
}

// Letters burnt into the picture, a sign: as far apart as lamps, and far brighter.
TEST(TrackScene, PairsThatStayAreNoVehiclesAndHideNone) {
  for (const double power : {1.0, 300.0}) {
    Scene made = mast();
    made.cars = {car(90, -4, -15), car(110, -7.5, -12)};
    for (const double x_m : {35.0, 42.0, 50.0, 60.0}) {
      made.cars.push_back(car(x_m, 4.0, 0.0));
      made.cars.back().power = power;
    }
    made.duration_s = 6.0;
    const auto outcome = scene::run(made);
    EXPECT_EQ(outcome.tracks.size(), 2U) << power;
    for (const int moving : {0, 1}) {
      EXPECT_EQ(outcome.tracks_of(moving), 1) << power;
      EXPECT_GE(outcome.recall(moving), 0.9) << power;
    }
    EXPECT_GE(outcome.counts.static_lights, 4) << power;
  }
}

TEST(TrackScene, AVehicleThatWaitsAndGoesIsReported) {
  Scene made = mast();
  made.cars = {car(60, -4, -12)};
  made.cars[0].stops_at_s = 1.0;
  made.cars[0].starts_again_s = 9.0;
  made.duration_s = 11.0;
  const auto outcome = scene::run(made);
  expect_each_car_once(outcome, 1, 0.9);
}

Scene low_dashcam(double pitched_deg) {
  Scene made = dashcam(14.0);
  made.site.road.lanes = {{"own", {0.0, 0.0}, 3.5, Direction::receding},
                          {"opp", {3.5, 0.0}, 3.5, Direction::oncoming}};
  made.told = made.site;
  made.told->camera->pitch_rad.mean += radians_from_degrees(pitched_deg);
  return made;
}

// Its elevation tells nothing 0.4 m under a camera that is pitched otherwise than the site says.
TEST(TrackScene, ALoneLampInAnOncomingLaneIsAVehicleBeforeADashcam) {
  for (const double speed_mps : {-4.0, -12.0, -20.0})
    for (const double off_deg : {-0.4, 0.0, 0.4}) {
      Scene made = low_dashcam(off_deg);
      made.cars = {car(90, 3.6, speed_mps)};
      made.cars[0].single = true;
      made.cars[0].height_m = 0.9;
      const auto outcome = scene::run(made);
      ASSERT_EQ(outcome.tracks.size(), 1U) << speed_mps << " " << off_deg;
      EXPECT_TRUE(outcome.tracks[0].single_lamp);
      EXPECT_EQ(outcome.tracks[0].direction, Direction::oncoming);
      EXPECT_GE(outcome.recall(0), 0.9);
    }
}

TEST(TrackScene, ALightBesideTheRoadIsNoLoneLampBeforeADashcam) {
  for (const double aside_m : {-4.5, 6.5, 8.0})
    for (const double off_deg : {-0.4, 0.0, 0.4}) {
      Scene made = low_dashcam(off_deg);
      made.street_lamps = {{70.0, aside_m, 0.9}};
      EXPECT_TRUE(scene::run(made).tracks.empty()) << aside_m << " " << off_deg;
    }
}

TEST(TrackScene, NothingButStreetLampsAndClutterIsNoVehicle) {
  for (const bool low : {false, true}) {
    Scene made = low ? dashcam(12.0) : mast();
    for (int i = 0; i < 8; ++i)
      made.street_lamps.push_back({30.0 + 18.0 * i, i % 2 ? 7.0 : -9.0, 8.0});
    made.clutter_per_frame = 2.0;
    made.duration_s = 8.0;
    EXPECT_TRUE(scene::run(made).tracks.empty()) << (low ? "dashcam" : "mast");
  }
}

TEST(TrackScene, NoRedLampInAnOncomingTrack) {
  Scene made = dashcam(14.0);
  made.cars = {car(110, 3.6, -8)};
  made.cars[0].turns_red_s = 2.4;
  const auto outcome = scene::run(made);
  ASSERT_FALSE(outcome.tracks.empty());
  const std::int64_t red_from = 60;
  for (const VehicleTrack& track : outcome.tracks)
    EXPECT_LE(track.sightings.back().frame, red_from);
}

TEST(TrackScene, LightsThatComeApartAreNotOneVehicle) {
  Scene made = mast();
  made.cars = {car(90, -3.4, -12), car(90, -4.6, -12)};  // two motorcycles abreast
  for (Car& one : made.cars) one.single = true;
  made.cars[1].stops_at_s = 3.0;
  made.duration_s = 6.0;
  const auto outcome = scene::run(made);
  const std::int64_t twice_as_far_apart = 75 + 5;  // 2.4 m at 12 m/s and 25 Hz
  for (const VehicleTrack& track : outcome.tracks)
    for (const VehicleSighting& sighting : track.sightings)
      EXPECT_FALSE(sighting.left && sighting.right && sighting.frame > twice_as_far_apart)
          << "track " << track.id << " frame " << sighting.frame;
}

TEST(TrackScene, BusIsItsHeadlampsNotItsRoofLights) {
  Scene made = tower();
  made.cars = {car(75, -4, -8), car(75, -4, -8)};
  made.cars[0].separation_m = 1.9;
  made.cars[0].hidden_s = {{0.0, 1.0}};  // behind another vehicle; the roof is seen first
  made.cars[1].height_m = 2.9;
  made.cars[1].power = 0.4;
  made.duration_s = 7.0;
  const auto outcome = scene::run(made);
  EXPECT_EQ(outcome.tracks_of(0), 1);
  EXPECT_GE(outcome.recall(0), 0.9);
  EXPECT_EQ(outcome.tracks_of(1), 0);
}

TEST(TrackScene, LampsOfVeryUnequalLightAreNoPair) {
  Scene made = mast();
  made.cars = {car(80, -4, -15)};
  made.cars[0].left_power = 0.05;
  const auto outcome = scene::run(made);
  for (const VehicleTrack& track : outcome.tracks) EXPECT_TRUE(track.single_lamp);
}

TEST(TrackScene, OneLampHiddenForAWhileDoesNotSplitTheTrack) {
  Scene made = mast();
  made.cars = {car(90, -4, -14)};
  made.cars[0].left_hidden_from_s = 1.5;
  made.cars[0].left_hidden_to_s = 3.0;
  const auto outcome = scene::run(made);
  expect_each_car_once(outcome, 1, 0.9);
}

TEST(TrackScene, ALampLeftAloneForLongIsNotTheVehicleAnyMore) {
  Scene made = mast();
  made.cars = {car(110, -4, -14)};
  made.cars[0].left_hidden_from_s = 2.0;
  made.duration_s = 6.0;
  const auto outcome = scene::run(made);
  ASSERT_FALSE(outcome.tracks.empty());
  const std::int64_t one_second_later = 75;
  EXPECT_FALSE(outcome.tracks[0].single_lamp);
  EXPECT_LE(outcome.tracks[0].sightings.back().frame, one_second_later);
}

// While its left lamp is dark the light that goes by it is followed instead, and lost a little
// later than the vehicle, which by then has its own lamp back.
TEST(TrackScene, ALightThatOutlivesTheVehicleWhoseLampItWasIsNoSecondOne) {
  Scene made = mast();
  made.wet = true;
  made.cars = {car(62, -4, -20), car(48.4, -3.375, -10)};
  made.cars[0].left_hidden_from_s = 1.36;
  made.cars[0].left_hidden_to_s = 1.66;
  made.cars[1].single = true;
  made.cars[1].hidden_s = {{0.0, 1.36}, {2.2, 9.0}};
  const auto outcome = scene::run(made);
  ASSERT_EQ(outcome.tracks.size(), 1U);
  EXPECT_FALSE(outcome.tracks[0].single_lamp);
  EXPECT_GE(outcome.recall(0), 0.85);
}

// One of its lamps went over to a light that was still there when it came out again.
TEST(TrackScene, AVehicleWhoseLampsWentAstrayIsFoundAgain) {
  Scene made = mast();
  made.cars = {car(90, -4, -15), car(81, -3.375, -9)};
  made.cars[0].hidden_s = {{1.5, 2.5}};
  made.cars[1].single = true;
  made.cars[1].hidden_s = {{0.0, 1.5}, {3.5, 9.0}};
  const auto outcome = scene::run(made);
  ASSERT_EQ(outcome.tracks.size(), 1U);
  EXPECT_EQ(outcome.car_of(0), 0) << "the track holds the other light";
  EXPECT_GE(outcome.recall(0), 0.95);
}

// Overtaking with a long time out of sight of both: whatever is reported is pure or says its doubt.
TEST(TrackScene, NeverSwapsInSilence) {
  int impure = 0, tracks = 0;
  for (int trial = 0; trial < 30; ++trial) {
    Random random(4100 + static_cast<std::uint64_t>(trial));
    Scene made = mast();
    made.seed = 900 + static_cast<std::uint64_t>(trial);
    const double gap_m = random.uniform(4.0, 12.0);
    made.cars = {car(90, -4, -random.uniform(8, 12)),
                 car(90 + gap_m, -4.0 - random.uniform(0, 3.5), -random.uniform(14, 22))};
    const double from_s = random.uniform(1.0, 2.0);
    for (Car& one : made.cars) one.hidden_s = {{from_s, from_s + random.uniform(0.2, 0.6)}};
    const auto outcome = scene::run(made);
    for (std::size_t i = 0; i < outcome.tracks.size(); ++i) {
      ++tracks;
      impure += !outcome.car_of(i) && !outcome.tracks[i].ambiguous_identity;
    }
  }
  EXPECT_EQ(impure, 0);
  EXPECT_GE(tracks, 50);
}

// From low down two cars in a lane are four lamps in a row, and three while the middle two are one
// blob: a pair that was held across the two cars for most of its time is not reported as a vehicle
// without doubt, and few true ones are doubted.
TEST(TrackScene, ARowOfFourLampsIsNotPairedAcrossInSilence) {
  constexpr double kMostOfTime = 0.65;  // share of its lamps that are one car's
  constexpr double kFew = 0.03;         // of 400 cars: 9 of 800 and three binomial sigmas
  int in_silence = 0, across = 0, doubted = 0, tracks = 0;
  for (int trial = 0; trial < 200; ++trial) {
    Random random(7300 + static_cast<std::uint64_t>(trial));
    Scene made = dashcam(14.0);
    made.site = scene::site_of(1.3, -2.0, 533.0, 640, 360);
    made.site.ego = EgoSite{Uncertain{14.0, 0.2}, {}, {}};
    made.seed = 300 + static_cast<std::uint64_t>(trial);
    made.resolution_px = 3.0;
    const double first_m = random.uniform(90.0, 130.0), speed_mps = random.uniform(8.0, 16.0);
    made.cars = {car(first_m, 3.5, -speed_mps),
                 car(first_m + random.uniform(15.0, 40.0), 3.5, -speed_mps)};
    for (Car& one : made.cars) {
      one.y_m = random.normal(3.5, 0.3);
      one.speed_mps -= random.normal(0.0, 0.7);
      one.height_m = random.normal(0.68, 0.08);
      one.separation_m = random.normal(1.25, 0.12);
    }
    const auto outcome = scene::run(made);
    for (std::size_t i = 0; i < outcome.tracks.size(); ++i) {
      int lamps = 0, most = 0;
      for (const auto& [owner, of_owner] : outcome.votes[i]) {
        lamps += of_owner;
        most = std::max(most, of_owner);
      }
      const bool is_across = !outcome.tracks[i].single_lamp && most < kMostOfTime * lamps;
      const bool doubt = outcome.tracks[i].ambiguous_identity;
      ++tracks;
      across += is_across;
      in_silence += is_across && !doubt;
      doubted += !is_across && doubt;
    }
  }
  EXPECT_EQ(in_silence, 0);
  EXPECT_GT(across, 0);  // else the scenes are too easy to show anything
  EXPECT_LE(doubted, kFew * tracks);
}

}  // namespace
}  // namespace vildar
