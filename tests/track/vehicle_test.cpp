#include "track/vehicle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "one_car.h"
#include "optics/lamp_colour.h"
#include "track/lone_course.h"

namespace vildar {
namespace {

using Road = scene::OneCar;

// Its way backwards.
void drive_away(Lamp& lamp) {
  const std::vector<LampRecord> seen = lamp.records;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const LampRecord& other = seen[seen.size() - 1 - i];
    lamp.records[i].at_px = other.at_px;
    lamp.records[i].sighting = other.sighting;
  }
}

// The lamp that took the place of a lost one had been followed before as a light of its own.
TEST(JudgeVehicle, OneSightingPerFrameInOrderThoughASideChangedItsLamp) {
  const Road road;
  Lamp lost = road.lamp(0, 20, -3.4), heir = road.lamp(8, 50, -3.4), right = road.lamp(0, 50, -4.6);
  Vehicle vehicle;
  vehicle.past_left = lost.records;
  vehicle.left = &heir;
  vehicle.right = &right;
  vehicle.both_seen = 40;
  VehicleTrack track;
  ASSERT_EQ(judge_vehicle(vehicle, road.view, {}, {}, track), Verdict::vehicle);
  ASSERT_EQ(track.sightings.size(), 51U);
  for (std::size_t i = 0; i < track.sightings.size(); ++i)
    EXPECT_EQ(track.sightings[i].frame, static_cast<std::int64_t>(i));
}

// In a queue the glare of those behind is followed as one light, out of which each vehicle comes.
TEST(JudgeVehicle, AShortTimeAsAPairVouchesForLittleOfALongOneAsALoneLight) {
  const Road road;
  Lamp left = road.lamp(0, 100, -3.4), right = road.lamp(92, 100, -4.6);
  Vehicle vehicle = scene::vehicle_of(left, right, 9);
  VehicleTrack track;
  ASSERT_EQ(judge_vehicle(vehicle, road.view, {}, {}, track), Verdict::vehicle);
  EXPECT_EQ(track.sightings.back().frame, 100);
  EXPECT_LE(track.sightings.size(), 60U);
  EXPECT_GE(track.sightings.size(), 20U);
}

// Two patches of lit road before a pair of lamps: as level, as far apart, as steady as a pair.
TEST(JudgeVehicle, LightsWiderThanLampsThatDoNotClipAreLitRoadUnlessTheyAreRedBars) {
  const Road road;
  constexpr double kWhite = -3.0, kRed = 4.0;  // ln of the odds of a tail lamp
  for (const double width_m : {0.8, 1.5})
    for (const int saturated_px : {0, 40})
      for (const double tail_log_odds : {kWhite, kRed})
        for (const double flatness : {0.1, 0.4}) {
          Lamp left = road.lamp(0, 50, -3.4), right = road.lamp(0, 50, -4.6);
          for (Lamp* lamp : {&left, &right})
            for (LampRecord& record : lamp->records) {
              const double range_m = 70.0 - 0.5 * static_cast<double>(record.frame);
              const double width_px = width_m * 1400.0 / range_m;
              record.sighting.box = {0, 0, static_cast<int>(width_px),
                                     static_cast<int>(flatness * width_px)};
              record.sighting.saturated_px = saturated_px;
              record.tail_log_odds = tail_log_odds;
            }
          Vehicle vehicle = scene::vehicle_of(left, right, 51);
          VehicleTrack track;
          const bool bar = tail_log_odds == kRed && flatness == 0.1;
          const bool patch = width_m > 1.0 && saturated_px == 0 && !bar;
          EXPECT_EQ(judge_vehicle(vehicle, road.view, {}, {}, track),
                    patch ? Verdict::reflection : Verdict::vehicle)
              << width_m << " m, " << saturated_px << " " << tail_log_odds << " " << flatness;
        }
}

// To a grey camera tail lamps are as white as headlamps.
TEST(JudgeVehicle, WithoutColourTheMotionTellsTheDirection) {
  const Road road;
  for (const bool grey : {false, true}) {
    LightScale lights;
    if (grey) lights.see_colour(0.0, 0.0);
    Lamp left = road.lamp(0, 50, -3.4), right = road.lamp(0, 50, -4.6);
    for (Lamp* lamp : {&left, &right}) drive_away(*lamp);
    Vehicle vehicle = scene::vehicle_of(left, right, 51);
    VehicleTrack track;
    ASSERT_EQ(judge_vehicle(vehicle, road.view, {}, lights, track), Verdict::vehicle);
    EXPECT_EQ(track.direction_contradicts, !grey);
    EXPECT_EQ(track.direction, grey ? Direction::receding : Direction::oncoming);
    EXPECT_EQ(track.kind, grey ? LampKind::taillamp : LampKind::headlamp);
  }
}

// Hazard lights on: amber in half of the pictures.
TEST(JudgeVehicle, AmongLightsThatAreNotWhiteTheMotionTellsTheDirection) {
  const Road road;
  const double kAmber = tail_lamp_log_odds(0.14, -0.29), kRed = tail_lamp_log_odds(0.12, -0.05);
  const double kWhite = tail_lamp_log_odds(0.012, -0.015);
  const double kWarmWhite = tail_lamp_log_odds(0.0, -0.08);
  for (const double blinks : {kAmber, kWhite, kWarmWhite}) {
    Lamp left = road.lamp(0, 50, -3.4), right = road.lamp(0, 50, -4.6);
    for (Lamp* lamp : {&left, &right}) {
      drive_away(*lamp);
      for (LampRecord& record : lamp->records)
        record.tail_log_odds = record.faint_tail_log_odds = record.frame % 20 < 12 ? blinks : kRed;
    }
    Vehicle vehicle = scene::vehicle_of(left, right, 51);
    VehicleTrack track;
    ASSERT_EQ(judge_vehicle(vehicle, road.view, {}, {}, track), Verdict::vehicle);
    EXPECT_EQ(track.direction_contradicts, blinks != kAmber);
    EXPECT_EQ(track.direction, blinks == kAmber ? Direction::receding : Direction::oncoming);
  }
}

// From a moving camera, the ends of two clusters of lights: a white one and an amber one.
TEST(JudgeVehicle, AWhiteLightAndAnAmberOneAreNoTailLamps) {
  constexpr double kAmber = -0.4, kWhite = -3.0;  // ln of the odds of a tail lamp
  Site site = scene::site_of(1.3, 0.0, 1400.0, 1920, 1080);
  site.ego = EgoSite{{10.0, 0.2}, {}, {}};
  const Road road{.site = site};
  for (const bool alike : {true, false}) {
    Lamp left = road.lamp(0, 50, 0.6), right = road.lamp(0, 50, -0.6);
    for (Lamp* lamp : {&left, &right}) {
      drive_away(*lamp);
      for (LampRecord& record : lamp->records)
        record.tail_log_odds = record.faint_tail_log_odds =
            alike || lamp == &right ? kAmber : kWhite;
    }
    Vehicle vehicle = scene::vehicle_of(left, right, 51);
    VehicleTrack track;
    EXPECT_EQ(judge_vehicle(vehicle, road.view, {}, {}, track),
              alike ? Verdict::vehicle : Verdict::undecided);
    if (alike) {
      EXPECT_EQ(track.direction, Direction::receding);
    }
  }
}

// The images on the road of two vehicles' lamps, as level and as far apart as a pair.
TEST(JudgeVehicle, LightsThatAreMostlyStreaksAreNone) {
  const Road road;
  for (const int streak_every : {1, 3}) {
    Lamp left = road.lamp(0, 50, -3.4), right = road.lamp(0, 20, -4.6);
    for (Lamp* lamp : {&left, &right})
      for (LampRecord& record : lamp->records) record.streak = record.frame % streak_every == 0;
    Vehicle vehicle = scene::vehicle_of(left, right, 21);
    VehicleTrack track;
    EXPECT_EQ(judge_vehicle(vehicle, road.view, {}, {}, track),
              streak_every == 1 ? Verdict::reflection : Verdict::vehicle);
  }
}

// Alone its left lamp was taken for one 12 m nearer, its right one for one a lane away.
TEST(JudgeVehicle, ALoneLightBesideTheWayOfThePairsWasAnotherLamp) {
  const Road road;
  Lamp left = road.lamp(22, 50, -3.4), right = road.lamp(30, 60, -4.6);
  Lamp nearer = road.lamp(10, 21, -3.4, 12.0), beside = road.lamp(61, 70, -8.1);
  right.records.insert(right.records.end(), beside.records.begin(), beside.records.end());
  Vehicle vehicle;
  vehicle.past_left = nearer.records;
  vehicle.left = &left;
  vehicle.right = &right;
  vehicle.both_seen = 21;
  VehicleTrack track;
  ASSERT_EQ(judge_vehicle(vehicle, road.view, {}, {}, track), Verdict::vehicle);
  EXPECT_EQ(track.sightings.front().frame, 22);
  EXPECT_EQ(track.sightings.back().frame, 60);
  EXPECT_EQ(track.sightings.size(), 39U);
}

// A motorcycle before or behind a car moves much as that car's lamps do.
TEST(JudgeSingle, WhatHasItsOwnImageOnTheRoadIsOnNoBody) {
  const Road road;
  for (const bool imaged : {false, true}) {
    Lamp lamp = road.lamp(0, 60, -4.0);
    for (int look = 0; look < 60; ++look) lamp.on_vehicle.add(look % 3 > 0, 12);
    for (LampRecord& record : lamp.records) record.casts_image = imaged;
    VehicleTrack track;
    EXPECT_EQ(judge_single(lamp, road.view, {}, {}, track),
              imaged ? Verdict::vehicle : Verdict::reflection);
  }
}

// Two looks of five at another glint.
TEST(JudgeSingle, AnImageDoesNotMakeALampOfWhatRidesAndStrays) {
  const Road road;
  for (const bool rides : {false, true}) {
    Lamp lamp = road.lamp(0, 60, -4.0);
    for (int look = 0; look < 60; ++look) lamp.on_vehicle.add(rides && look % 3 > 0, 12);
    for (std::size_t i = 0; i < lamp.records.size(); ++i) {
      lamp.records[i].casts_image = true;
      if (i % 5 < 2) lamp.records[i].at_px.x() += 9.0;
    }
    VehicleTrack track;
    EXPECT_EQ(judge_single(lamp, road.view, {}, {}, track),
              rides ? Verdict::reflection : Verdict::vehicle);
  }
}

// Far off it and a lamp of the car beside it moved as one vehicle's.
TEST(JudgeSingle, ALightOnceTakenForOneOfAPairIsALampIfItIsLongAlone) {
  const Road road;
  Lamp motorcycle = road.lamp(0, 80, -4.0), part = road.lamp(0, 12, -4.0);
  motorcycle.paired_sightings = 25;
  part.paired_sightings = 60;
  VehicleTrack track;
  EXPECT_EQ(judge_single(motorcycle, road.view, {}, {}, track), Verdict::vehicle);
  EXPECT_EQ(judge_single(part, road.view, {}, {}, track), Verdict::undecided);
}

// For most of its time in view it is no lower than the camera, as far as the pose is known.
TEST(JudgeSingle, OneThatComesFromAfarIsToldWhereItIsBelowTheCamera) {
  Site site = scene::site_of(5.0, -4.0, 1400.0, 1920, 1080);
  site.camera->pitch_rad.std = 0.01;
  const Road road{.site = site};
  VehicleTrack track;
  const Lamp comes = road.lamp(0, 680, -4.0, -330.0);
  ASSERT_EQ(judge_single(comes, road.view, {}, {}, track), Verdict::vehicle);
  EXPECT_EQ(track.direction, Direction::oncoming);
  EXPECT_EQ(std::ssize(track.sightings), 681);
  const Lamp turns_off = road.lamp(0, 380, -4.0, -330.0);
  EXPECT_EQ(judge_single(turns_off, road.view, {}, {}, track), Verdict::undecided);
}

TEST(JudgeSingle, OfOneThatIsNotWhiteTheMotionTellsTheDirection) {
  const Road road;
  for (const double tail_log_odds : {-3.0, -0.4}) {
    Lamp lamp = road.lamp(0, 60, -4.0);
    drive_away(lamp);
    for (LampRecord& record : lamp.records) record.faint_tail_log_odds = tail_log_odds;
    VehicleTrack track;
    ASSERT_EQ(judge_single(lamp, road.view, {}, {}, track), Verdict::vehicle);
    EXPECT_EQ(track.direction_contradicts, tail_log_odds < -1.2);
  }
}

// Three cars are known, whose lamps are that much stronger: a bicycle's is, or one seen after the
// exposure was turned down.
Verdict among_cars(const Road& road, const Lamp& lamp, LampKind kind, double stronger_ln) {
  const double inverse_depth_per_m = road.view.place(lamp.records[30].at_px).inverse_depth_per_m;
  LightScale lights;
  for (int car = 0; car < 3; ++car)
    lights.add(kind, std::log(100.0) - 2.0 * std::log(inverse_depth_per_m) + stronger_ln, 0.1,
               false);
  VehicleTrack track;
  return judge_single(lamp, road.view, {}, lights, track);
}

TEST(JudgeSingle, ATailLampMayBeFarFainterThanThoseOfCars) {
  const Road road;
  Lamp bicycle = road.lamp(0, 60, -4.0, 0.0, 100.0, LampKind::taillamp);
  drive_away(bicycle);
  EXPECT_EQ(among_cars(road, bicycle, LampKind::taillamp, 2.2), Verdict::vehicle);
  EXPECT_EQ(among_cars(road, bicycle, LampKind::taillamp, 3.0), Verdict::undecided);
  EXPECT_EQ(among_cars(road, road.lamp(0, 60, -4.0), LampKind::headlamp, 2.2), Verdict::undecided);
}

// Level with a tripod that is pitched otherwise than told: its elevation tells no course.
TEST(JudgeSingle, OneThatPassesLevelWithTheCameraIsOnNoCourseByItsElevation) {
  Site site = scene::site_of(1.3, 0.0, 1000.0, 1280, 720);
  site.camera->pitch_rad.std = 0.05;
  site.road.lanes = {{"out", {-4.0, 0.3}, 3.5, Direction::receding}};
  Site true_site = site;
  true_site.camera->pitch_rad.mean += -0.03;
  const Road road{.site = site, .view = RoadView(site), .camera = Camera(*true_site.camera)};
  Lamp motorcycle = road.lamp(0, 125, -4.0, 0.0, 100.0, LampKind::taillamp);
  drive_away(motorcycle);
  EXPECT_GT(off_course_share(motorcycle.records, road.view), 0.5);
  EXPECT_EQ(among_cars(road, motorcycle, LampKind::taillamp, 2.2), Verdict::vehicle);
}

// Near the end it may have passed to another light: what it was until then stays.
TEST(JudgeSingle, ALampKeepsItsLongestTimeWithoutADoubt) {
  const Road road;
  Lamp lamp = road.lamp(0, 60, -3.4);
  lamp.doubtful_at = Road::time_at(5);
  lamp.set_aside_before(Road::time_at(5));
  lamp.doubtful_at = Road::time_at(56);
  lamp.set_aside_before(Road::time_at(56));
  VehicleTrack track;
  EXPECT_EQ(judge_single(lamp, road.view, {}, {}, track), Verdict::undecided);
  EXPECT_EQ(judge_single(lamp.before_doubt(), road.view, {}, {}, track), Verdict::vehicle);
  ASSERT_EQ(track.sightings.size(), 51U);
  EXPECT_EQ(track.sightings.front().frame, 5);
  EXPECT_FALSE(track.ambiguous_identity);
  lamp.start_anew(Road::time_at(60), 0);
  EXPECT_TRUE(lamp.set_aside.empty());
}

TEST(JudgeSingle, ALightThatIsASeenStreakWheneverItIsUnseenIsNoLamp) {
  const Road road;
  Lamp lamp = road.lamp(0, 20, -4.0);
  VehicleTrack track;
  EXPECT_EQ(judge_single(lamp, road.view, {}, {}, track), Verdict::vehicle);
  for (int frame = 0; frame < 30; ++frame) lamp.reflected.add(true, 12);
  EXPECT_EQ(judge_single(lamp, road.view, {}, {}, track), Verdict::reflection);
}

TEST(JudgeVehicle, NothingOfWhatCameAfterTheCut) {
  const Road road;
  Lamp left = road.lamp(0, 50, -3.4), right = road.lamp(0, 50, -4.6);
  Vehicle vehicle = scene::vehicle_of(left, right, 50);
  vehicle.cut_after = 30;
  VehicleTrack track;
  ASSERT_EQ(judge_vehicle(vehicle, road.view, {}, {}, track), Verdict::vehicle);
  EXPECT_EQ(track.sightings.back().frame, 30);
}

TEST(JudgeVehicle, WhatWasComingApartWhenLastSeenIsReportedAsFarAsItWasGood) {
  const Road road;
  Lamp left = road.lamp(0, 70, -3.4), right = road.lamp(0, 70, -4.6);
  const auto judge = [&](std::int64_t last_good, double chi2) {
    Vehicle vehicle = scene::vehicle_of(left, right, 71);
    vehicle.last_both = 70;
    vehicle.last_good = last_good;
    vehicle.chi2 = chi2;
    cut_where_it_came_apart(vehicle);
    VehicleTrack track;
    const Verdict verdict = judge_vehicle(vehicle, road.view, {}, {}, track);
    return std::tuple(verdict, verdict == Verdict::vehicle ? track.sightings.back().frame : -1,
                      verdict == Verdict::vehicle && track.ambiguous_identity);
  };
  EXPECT_EQ(judge(60, 12.0), std::tuple(Verdict::vehicle, 60, false));
  EXPECT_EQ(judge(40, 12.0), std::tuple(Verdict::vehicle, 40, true));
  EXPECT_EQ(judge(15, 12.0), std::tuple(Verdict::undecided, -1, false));
  EXPECT_EQ(judge(60, 10.0), std::tuple(Verdict::vehicle, 70, false));
  EXPECT_EQ(judge(70, 12.0), std::tuple(Verdict::undecided, -1, false))
      << "good when last seen, and yet bad";
}

// Far off its right lamp was taken for the partner of a post's reflector, twice as far aside.
TEST(JudgeVehicle, OfLampsThatStepApartTheLongestPairIsKept) {
  const Road road;
  const auto judge = [&](std::int64_t step) {
    Lamp left = road.lamp(0, 60, -3.4);
    Lamp right = road.lamp(0, 60, [&](std::int64_t frame) { return frame < step ? -7.0 : -4.6; });
    Vehicle vehicle = scene::vehicle_of(left, right, 61);
    VehicleTrack track;
    EXPECT_EQ(judge_vehicle(vehicle, road.view, {}, {}, track), Verdict::vehicle) << step;
    return track;
  };
  const VehicleTrack mostly = judge(15);
  EXPECT_EQ(mostly.sightings.front().frame, 15);
  EXPECT_EQ(mostly.sightings.back().frame, 60);
  EXPECT_FALSE(mostly.ambiguous_identity);
  const VehicleTrack doubtful = judge(28);
  EXPECT_EQ(doubtful.sightings.front().frame, 28);
  EXPECT_TRUE(doubtful.ambiguous_identity);
  // A glimpse of something else in between is left out alone.
  Lamp left = road.lamp(0, 60, -3.4);
  Lamp right =
      road.lamp(0, 60, [](std::int64_t frame) { return frame >= 28 && frame < 32 ? -7.0 : -4.6; });
  Vehicle glimpsed = scene::vehicle_of(left, right, 61);
  VehicleTrack whole;
  ASSERT_EQ(judge_vehicle(glimpsed, road.view, {}, {}, whole), Verdict::vehicle);
  EXPECT_EQ(whole.sightings.front().frame, 0);
  EXPECT_EQ(whole.sightings.back().frame, 60);
  EXPECT_EQ(whole.sightings.size(), 57U);
  EXPECT_FALSE(whole.ambiguous_identity);
  const VehicleTrack never = judge(0);
  EXPECT_EQ(never.sightings.front().frame, 0);
}

// A camera that shows colour holds white lamps that drive away against them; a grey one does not.
TEST(JudgeVehicle, WithoutColourWhatDrivesAwayHasTailLamps) {
  const Road road;
  for (const bool grey : {false, true}) {
    Lamp left = road.lamp(0, 50, -3.4), right = road.lamp(0, 50, -4.6);
    for (Lamp* lamp : {&left, &right}) {
      drive_away(*lamp);
      for (LampRecord& record : lamp->records)
        record.tail_log_odds = record.faint_tail_log_odds = -3.0;
    }
    LightScale lights;
    for (int i = 0; i < 100; ++i) lights.see_colour(grey ? 0.0 : 0.05, 0.0);
    Vehicle vehicle = scene::vehicle_of(left, right, 51);
    VehicleTrack track;
    ASSERT_EQ(judge_vehicle(vehicle, road.view, {}, lights, track), Verdict::vehicle);
    EXPECT_EQ(track.kind, grey ? LampKind::taillamp : LampKind::headlamp);
    EXPECT_EQ(track.direction, grey ? Direction::receding : Direction::oncoming);
    EXPECT_EQ(track.direction_contradicts, !grey);
  }
}

}  // namespace
}  // namespace vildar
