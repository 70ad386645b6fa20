#include "track/lone_tracks.h"

#include <memory>

#include <gtest/gtest.h>

#include "one_car.h"
#include "scene.h"
#include "track/vehicle.h"

namespace vildar {
namespace {

using Road = scene::OneCar;

VehicleTrack track_of(const Lamp& lamp) {
  VehicleTrack track;
  track.single_lamp = true;
  for (const LampRecord& record : lamp.records)
    track.sightings.push_back({record.frame, record.time, record.sighting, std::nullopt});
  return track;
}

// A motorcycle, hidden from frame 31 to 59.
struct Hidden {
  Road road;
  LoneTracks lone;
  Lamp before = road.lamp(0, 30, -4.0);

  std::optional<VehicleTrack> add(const Lamp& lamp, bool drove_out = false) {
    return lone.add(track_of(lamp), lamp, drove_out, road.view);
  }
};

TEST(LoneTracks, HiddenForASecondIsOneTrack) {
  Hidden made;
  EXPECT_FALSE(made.add(made.before));
  EXPECT_FALSE(made.add(made.road.lamp(60, 80, -4.0)));
  const auto tracks = made.lone.take_all();
  ASSERT_EQ(tracks.size(), 1U);
  ASSERT_EQ(tracks[0].sightings.size(), 31U + 21U);
  EXPECT_EQ(tracks[0].sightings[30].frame, 30);
  EXPECT_EQ(tracks[0].sightings[31].frame, 60);
  EXPECT_FALSE(made.lone.oldest());
}

TEST(LoneTracks, AnotherOneIsAnotherTrack) {
  struct Place {
    double y_m, ahead_m;
  };
  for (const Place& place : {Place{-4.0, 8.0}, Place{-4.0, -8.0}, Place{-5.5, 0.0}}) {
    Hidden made;
    made.add(made.before);
    made.add(made.road.lamp(60, 80, place.y_m, place.ahead_m));
    EXPECT_EQ(made.lone.take_all().size(), 2U) << place.y_m << " " << place.ahead_m;
  }
  // Seen together they are two.
  Hidden made;
  made.add(made.before);
  made.add(made.road.lamp(30, 80, -4.0));
  EXPECT_EQ(made.lone.take_all().size(), 2U);
  // A tail lamp is another's.
  const Lamp lamp = made.road.lamp(60, 80, -4.0);
  VehicleTrack red = track_of(lamp);
  red.kind = LampKind::taillamp;
  made.add(made.before);
  made.lone.add(red, lamp, false, made.road.view);
  EXPECT_EQ(made.lone.take_all().size(), 2U);
}

TEST(LoneTracks, WhereTwoWouldDoNoneIsTaken) {
  Hidden made;
  made.add(made.before);
  made.add(made.road.lamp(0, 30, -4.4));
  made.add(made.road.lamp(60, 80, -4.2));
  EXPECT_EQ(made.lone.take_all().size(), 3U);
}

TEST(LoneTracks, WhatDroveOutDoesNotWait) {
  Hidden made;
  made.add(made.before);
  const auto done = made.add(made.road.lamp(60, 80, -4.0), true);
  ASSERT_TRUE(done);
  EXPECT_EQ(done->sightings.size(), 31U + 21U);
  EXPECT_TRUE(made.lone.take_all().empty());
}

TEST(LoneTracks, WaitsAsLongAsItMayBeFoundOrIsFollowed) {
  Hidden made;
  made.add(made.before);
  ASSERT_TRUE(made.lone.oldest());
  EXPECT_EQ(made.lone.oldest()->frame, 0);
  Lamps lamps;
  const auto done_at = [&](std::int64_t frame) {
    return made.lone.take_done(Road::time_at(frame), lamps, made.road.view).size();
  };
  lamps.push_back(std::make_unique<Lamp>(made.road.lamp(60, 100, -4.0)));
  lamps.push_back(std::make_unique<Lamp>(made.road.lamp(60, 100, -7.5)));
  lamps[0]->id = 1;
  lamps[1]->id = 2;
  EXPECT_EQ(done_at(30 + 80), 0U);
  EXPECT_EQ(done_at(30 + 100), 0U);
  EXPECT_EQ(done_at(30 + 200), 0U);
  // Now it has turned out to be a lamp of a car.
  Vehicle car;
  lamps[0]->vehicle = &car;
  EXPECT_EQ(done_at(30 + 201), 1U);

  made.add(made.before);
  lamps.erase(lamps.begin());
  EXPECT_EQ(done_at(30 + 80), 0U);
  EXPECT_EQ(done_at(30 + 100), 1U);
}

TEST(LoneTracks, TheLightItWaitedForAndNoOther) {
  Hidden made;
  made.add(made.before);
  Lamps lamps;
  lamps.push_back(std::make_unique<Lamp>(made.road.lamp(60, 100, -4.0)));
  lamps.front()->id = 2;
  EXPECT_TRUE(made.lone.take_done(Road::time_at(130), lamps, made.road.view).empty());
  // Another that is where it would have got to, and ends first.
  made.add(made.road.lamp(70, 90, -4.0));
  made.add(*lamps.front());
  const auto tracks = made.lone.take_all();
  ASSERT_EQ(tracks.size(), 2U);
  EXPECT_EQ(tracks[0].sightings.front().frame, 70);
  EXPECT_EQ(tracks[1].sightings.size(), 31U + 41U);
  // A doubtful step sets what was seen of it at first aside, and it is the same light.
  made.add(made.before);
  EXPECT_TRUE(made.lone.take_done(Road::time_at(130), lamps, made.road.view).empty());
  lamps.front()->set_aside_before(Road::time_at(80));
  made.add(*lamps.front());
  const auto doubted = made.lone.take_all();
  ASSERT_EQ(doubted.size(), 1U);
  EXPECT_EQ(doubted[0].sightings.size(), 31U + 21U);
  // Nor one that comes more than 3.5 s later, or stands.
  made.add(made.before);
  made.add(made.road.lamp(119, 135, -4.0));
  EXPECT_EQ(made.lone.take_all().size(), 2U);
  made.add(made.before);
  lamps.front()->fixed = true;
  EXPECT_EQ(made.lone.take_done(Road::time_at(130), lamps, made.road.view).size(), 1U);
}

// Through the tracker: a motorcycle and a car, hidden for 1.2 s and 3 s, before a camera on a mast;
// and the car without the second half of its way.
TEST(LoneTracks, OneTrackEachFromTheTracker) {
  scene::Scene made;
  made.site = scene::site_of(5.0, -4.0, 1400.0, 1920, 1080);
  made.duration_s = 6.0;
  scene::Car motorcycle;
  motorcycle.x_m = 90.0, motorcycle.single = true, motorcycle.hidden_s = {{1.6, 2.8}};
  scene::Car car;
  car.x_m = 110.0, car.y_m = -7.5, car.hidden_s = {{1.6, 4.6}};
  made.cars = {motorcycle, car};
  for (const double shake_px : {0.0, 1.0}) {
    made.shake_px = shake_px;
    const auto outcome = scene::run(made);
    ASSERT_EQ(outcome.tracks.size(), 2U) << shake_px;
    for (const int vehicle : {0, 1}) {
      EXPECT_EQ(outcome.tracks_of(vehicle), 1);
      EXPECT_GE(outcome.recall(vehicle), 0.9);
    }
    EXPECT_EQ(outcome.tracks[0].id, 1);
    EXPECT_EQ(outcome.tracks[1].id, 2);
  }
  // The clip ends while both are waited for.
  made.duration_s = 2.4;
  made.shake_px = 0.0;
  EXPECT_EQ(scene::run(made).tracks.size(), 2U);
}

}  // namespace
}  // namespace vildar
