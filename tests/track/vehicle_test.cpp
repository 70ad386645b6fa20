#include "track/vehicle.h"

#include <gtest/gtest.h>

#include "optics/camera.h"
#include "scene.h"

namespace vildar {
namespace {

struct Road {
  Site site = scene::site_of(5.0, -4.0, 1400.0, 1920, 1080);
  RoadView view{site};
  Camera camera{*site.camera};

  Spot spot(Blob& blob, std::int64_t frame, double y_m) const {
    blob.centre_px = *camera.project({70.0 - 0.5 * static_cast<double>(frame), y_m, 0.68});
    blob.flux = 100.0;
    blob.kind = LampKind::headlamp;
    return {&blob, *view.spot_from_pixel(blob.centre_px), 0.5, blob.centre_px,
            blob.centre_sigma_px};
  }

  Lamp lamp(std::int64_t from, std::int64_t to, double y_m) const {
    Blob blob;
    const Spot first = spot(blob, from, y_m);
    Lamp made(first, view.place(first.at_px), from, time_at(from), view);
    for (std::int64_t frame = from + 1; frame <= to; ++frame) {
      made.predict(0.04, view);
      made.update(spot(blob, frame, y_m), frame, time_at(frame));
    }
    return made;
  }

  static CameraTime time_at(std::int64_t frame) {
    return time_from_seconds<CameraTime>(0.04 * static_cast<double>(frame));
  }
};

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
  Vehicle vehicle;
  vehicle.left = &left;
  vehicle.right = &right;
  vehicle.both_seen = 9;
  VehicleTrack track;
  ASSERT_EQ(judge_vehicle(vehicle, road.view, {}, {}, track), Verdict::vehicle);
  EXPECT_EQ(track.sightings.back().frame, 100);
  EXPECT_LE(track.sightings.size(), 60U);
  EXPECT_GE(track.sightings.size(), 20U);
}

TEST(JudgeVehicle, NothingOfWhatCameAfterTheCut) {
  const Road road;
  Lamp left = road.lamp(0, 50, -3.4), right = road.lamp(0, 50, -4.6);
  Vehicle vehicle;
  vehicle.left = &left;
  vehicle.right = &right;
  vehicle.both_seen = 50;
  vehicle.cut_after = 30;
  VehicleTrack track;
  ASSERT_EQ(judge_vehicle(vehicle, road.view, {}, {}, track), Verdict::vehicle);
  EXPECT_EQ(track.sightings.back().frame, 30);
}

}  // namespace
}  // namespace vildar
