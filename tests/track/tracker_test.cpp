#include "track/tracker.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "scene.h"

namespace vildar {
namespace {

TEST(TrackOptions, ProblemsNameEveryField) {
  EXPECT_TRUE(TrackOptions{}.problems().empty());
  const TrackOptions bad{-1.0, 1, -0.1, -1.0, 0.0};
  const auto problems = bad.problems();
  ASSERT_EQ(problems.size(), 5U);
  EXPECT_NE(problems[0].find("longest_gap_s"), std::string::npos);
  EXPECT_THROW(Tracker(bad, scene::site_of(5, -4, 1400, 1920, 1080)), std::invalid_argument);
}

TEST(Tracker, NeedsACamera) {
  EXPECT_THROW(Tracker(TrackOptions{}, Site{}), std::invalid_argument);
}

TEST(Tracker, RefusesTimeThatStandsStill) {
  Tracker tracker({}, scene::site_of(5, -4, 1400, 1920, 1080));
  BlobFrame frame;
  tracker.update(frame);
  EXPECT_THROW(tracker.update(frame), std::invalid_argument);
}

TEST(Tracker, EmptyFramesAndFinishGiveNothing) {
  Tracker tracker({}, scene::site_of(5, -4, 1400, 1920, 1080));
  for (int k = 0; k < 5; ++k) {
    BlobFrame frame;
    frame.frame = k;
    frame.time = time_from_seconds<CameraTime>(0.04 * k);
    EXPECT_TRUE(tracker.update(frame).empty());
  }
  EXPECT_FALSE(tracker.live_since());
  EXPECT_TRUE(tracker.finish().empty());
}

TEST(Tracker, ShortVisitsAreCountedNotReported) {
  scene::Scene made;
  made.site = scene::site_of(5, -4, 1400, 1920, 1080);
  made.miss_share = 0.0;
  made.cars.resize(1);
  made.cars[0].hidden_s = {{0.14, 99.0}};  // four frames
  made.duration_s = 2.0;
  const auto outcome = scene::run(made);
  EXPECT_TRUE(outcome.tracks.empty());
  EXPECT_GE(outcome.counts.short_tracks, 1);
  EXPECT_EQ(outcome.counts.blobs, 8);
}

TEST(Tracker, AVehicleBesideTheLanesIsToldAsOne) {
  scene::Scene made;
  made.site = scene::site_of(5, -4, 1400, 1920, 1080);
  made.site.road.lanes = {{"near", {-4.0, 0.0}, 3.5, Direction::oncoming}};
  made.cars = {scene::Car{}, scene::Car{}};
  made.cars[1].y_m = 9.0;
  const auto outcome = scene::run(made);
  ASSERT_EQ(outcome.tracks.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const std::optional<double>& beside_m = outcome.tracks[i].beside_lanes_m;
    ASSERT_TRUE(outcome.car_of(i));
    EXPECT_EQ(beside_m.has_value(), outcome.car_of(i) == 1);
    EXPECT_NEAR(beside_m.value_or(9.0), 9.0, 0.5);
  }
}

// A parked car with its lamps on before a dashcam seems to come as the dashcam drives.
TEST(Tracker, WhatStandsBesideTheLanesIsNoVehicle) {
  scene::Scene made;
  made.site = scene::site_of(1.3, 0, 1400, 1920, 1080);
  made.site.road.lanes = {{"own", {0.0, 0.0}, 3.5, Direction::receding}};
  made.site.ego = EgoSite{{14.0, 0.0}, {}, {}};
  made.cars = {scene::Car{}};
  made.cars[0].y_m = 9.0;
  made.cars[0].speed_mps = 0.0;
  const auto stands = scene::run(made);
  EXPECT_TRUE(stands.tracks.empty());
  EXPECT_EQ(stands.counts.off_road, 1);
  made.cars[0].speed_mps = -14.0;
  const auto drives = scene::run(made);
  ASSERT_EQ(drives.tracks.size(), 1U);
  EXPECT_TRUE(drives.tracks[0].beside_lanes_m);
}

// With the pitch's sign wrong all lamps are over the horizon.
TEST(Tracker, LightsThatMoveAndAreNoVehiclesAreCounted) {
  scene::Scene made;
  made.site = scene::site_of(5, -4, 1400, 1920, 1080);
  made.cars = {scene::Car{}};
  EXPECT_EQ(scene::run(made).counts.moving_lights, 0);
  made.told = made.site;
  made.told->camera->pitch_rad.mean *= -1.0;
  const auto outcome = scene::run(made);
  EXPECT_TRUE(outcome.tracks.empty());
  EXPECT_EQ(outcome.counts.moving_lights, 2);
}

TEST(Tracker, IdsRiseWithTheFirstSighting) {
  scene::Scene made;
  made.site = scene::site_of(5, -4, 1400, 1920, 1080);
  for (int i = 0; i < 4; ++i) {
    scene::Car one;
    one.x_m = 70.0;
    one.speed_mps = -25.0;
    one.hidden_s = {{0.0, 1.5 * i}};
    one.x_m += 25.0 * 1.5 * i;
    made.cars.push_back(one);
  }
  made.duration_s = 10.0;
  const auto outcome = scene::run(made);
  ASSERT_EQ(outcome.tracks.size(), 4U);
  EXPECT_EQ(outcome.tracks[0].id, 1);
  for (std::size_t i = 1; i < 4; ++i) {
    EXPECT_GT(outcome.tracks[i].id, outcome.tracks[i - 1].id);
    EXPECT_GT(outcome.tracks[i].sightings.front().frame,
              outcome.tracks[i - 1].sightings.front().frame);
  }
}

TEST(Tracker, LiveSinceIsTheOldestLampThatMayBecomeAVehicle) {
  const Site site = scene::site_of(5, -4, 1400, 1920, 1080);
  const Camera camera(*site.camera);
  Tracker tracker({}, site);
  for (int k = 0; k < 50; ++k) {
    BlobFrame frame;
    frame.frame = k;
    frame.time = time_from_seconds<CameraTime>(0.04 * k);
    Blob street;
    street.centre_px = {200.0, 100.0};
    street.flux = 500.0;
    street.kind = LampKind::headlamp;
    frame.blobs.push_back(street);
    if (k >= 30) {
      Blob lamp = street;
      lamp.centre_px = *camera.project({80.0 - 0.6 * k, -4.0, 0.68});
      frame.blobs.push_back(lamp);
    }
    tracker.update(frame);
  }
  ASSERT_TRUE(tracker.live_since());
  EXPECT_NEAR(seconds_of(*tracker.live_since()), 1.2, 1e-9);
}

}  // namespace
}  // namespace vildar
