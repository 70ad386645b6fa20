#include "track/lone_tracks.h"

#include <memory>

#include <gtest/gtest.h>

#include "one_car.h"
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
    return lone.add(track_of(lamp), lamp.records, drove_out, road.view);
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
  VehicleTrack red = track_of(made.road.lamp(60, 80, -4.0));
  red.kind = LampKind::taillamp;
  made.add(made.before);
  made.lone.add(red, made.road.lamp(60, 80, -4.0).records, false, made.road.view);
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

}  // namespace
}  // namespace vildar
