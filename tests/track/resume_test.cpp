#include "track/resume.h"

#include <gtest/gtest.h>

#include "optics/camera.h"
#include "scene.h"

namespace vildar {
namespace {

// Before a mast: a car that comes nearer by half a metre a frame.
struct Road {
  Site site = scene::site_of(5.0, -4.0, 1400.0, 1920, 1080);
  RoadView view{site};
  Camera camera{*site.camera};

  Lamp lamp(std::int64_t first, std::int64_t last, double y_m, double ahead_m = 0.0) const {
    std::optional<Lamp> made;
    for (std::int64_t frame = first; frame <= last; ++frame) {
      Blob blob;
      blob.centre_px =
          *camera.project({70.0 - ahead_m - 0.5 * static_cast<double>(frame), y_m, 0.68});
      blob.flux = 100.0;
      blob.kind = LampKind::headlamp;
      const Spot spot{&blob, *view.spot_from_pixel(blob.centre_px), 0.5, blob.centre_px,
                      blob.centre_sigma_px};
      const auto time = time_from_seconds<CameraTime>(0.04 * static_cast<double>(frame));
      if (!made) {
        made.emplace(spot, view.place(spot.at_px), frame, time, view);
      } else {
        made->predict(0.04, view);
        made->update(spot, frame, time);
      }
    }
    return *made;
  }
};

// A car found in frames 42 to 46, shifted from where the lost one would be.
struct Found {
  Lamp left, right;
  Vehicle vehicle;
  Found(const Road& road, double ahead_m, double beside_m)
      : left(road.lamp(42, 46, -3.4 + beside_m, ahead_m)),
        right(road.lamp(42, 46, -4.6 + beside_m, ahead_m)) {
    vehicle.left = &left;
    vehicle.right = &right;
    vehicle.both_seen = 1;
  }
};

Vehicle lost_by(const Road& road, std::int64_t last) {
  Vehicle lost;
  lost.past_left = road.lamp(0, last, -3.4).records;
  lost.past_right = road.lamp(0, last, -4.6).records;
  lost.both_seen = static_cast<int>(last) + 1;
  return lost;
}

TEST(GoesOn, WhereTheLostVehicleWouldBeAndNowhereElse) {
  const Road road;
  const Vehicle lost = lost_by(road, 30);
  EXPECT_TRUE(goes_on(lost, Found(road, 0.0, 0.0).vehicle, road.view));
  EXPECT_TRUE(goes_on(lost, Found(road, 1.0, 0.3).vehicle, road.view));
  // The next one in the lane, one in the next lane, one seen together with it.
  EXPECT_FALSE(goes_on(lost, Found(road, -8.0, 0.0).vehicle, road.view));
  EXPECT_FALSE(goes_on(lost, Found(road, 8.0, 0.0).vehicle, road.view));
  EXPECT_FALSE(goes_on(lost, Found(road, 0.0, -2.5).vehicle, road.view));
  EXPECT_FALSE(goes_on(lost_by(road, 44), Found(road, 0.0, 0.0).vehicle, road.view));
  // Hardly seen; and tail lamps are another vehicle's.
  EXPECT_FALSE(goes_on(lost_by(road, 5), Found(road, 0.0, 0.0).vehicle, road.view));
  Found red(road, 0.0, 0.0);
  red.vehicle.kind = LampKind::taillamp;
  EXPECT_FALSE(goes_on(lost, red.vehicle, road.view));
}

TEST(Resume, OneTrackWithoutWhatCameAfterTheCut) {
  const Road road;
  Vehicle lost = lost_by(road, 35);
  lost.cut_after = 30;
  lost.came_apart = true;
  Found found(road, 0.0, 0.0);
  ASSERT_TRUE(goes_on(lost, found.vehicle, road.view));
  resume(lost, found.vehicle);
  VehicleTrack track;
  ASSERT_EQ(judge_vehicle(found.vehicle, road.view, {}, {}, track), Verdict::vehicle);
  ASSERT_EQ(track.sightings.size(), 31U + 5U);
  EXPECT_EQ(track.sightings[30].frame, 30);
  EXPECT_EQ(track.sightings[31].frame, 42);
  EXPECT_FALSE(track.ambiguous_identity);
}

}  // namespace
}  // namespace vildar
