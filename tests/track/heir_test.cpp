#include "track/heir.h"

#include <gtest/gtest.h>

#include "optics/camera.h"
#include "scene.h"

namespace vildar {
namespace {

constexpr std::int64_t kSplit = 30;  // frame in which one blob becomes two

// A car 1.2 m wide that comes nearer by half a metre a frame, and a light to the right of it.
struct Road {
  Site site = scene::site_of(5.0, -4.0, 1400.0, 1920, 1080);
  RoadView view{site};
  Camera camera{*site.camera};

  // At y_m up to kSplit, then at later_m.
  Lamp lamp(std::int64_t first, std::int64_t last, double y_m, double later_m) const {
    std::optional<Lamp> made;
    for (std::int64_t frame = first; frame <= last; ++frame) {
      Blob blob;
      blob.centre_px = *camera.project(
          {70.0 - 0.5 * static_cast<double>(frame), frame < kSplit ? y_m : later_m, 0.68});
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

TEST(HandOver, TheVehicleKeepsTheLampThatCameOutOfTheCommonBlob) {
  const Road road;
  Lamp left = road.lamp(0, 50, -3.4, -3.4), old = road.lamp(0, 50, -4.7, -4.8);
  Lamp heir = road.lamp(kSplit, 50, 0.0, -4.6);
  Vehicle vehicle;
  vehicle.left = &left;
  vehicle.right = &old;
  vehicle.both_seen = 50;
  left.vehicle = old.vehicle = &vehicle;
  ASSERT_TRUE(hand_over(vehicle, left, heir));
  EXPECT_EQ(vehicle.right, &heir);
  EXPECT_EQ(heir.vehicle, &vehicle);
  EXPECT_EQ(old.vehicle, nullptr);
  EXPECT_EQ(old.records.front().frame, kSplit);

  VehicleTrack track;
  ASSERT_EQ(judge_vehicle(vehicle, road.view, {}, {}, track), Verdict::vehicle);
  ASSERT_EQ(track.sightings.size(), 51U);
  for (const VehicleSighting& sighting : track.sightings) {
    const Eigen::Vector2d truth_px =
        *road.camera.project({70.0 - 0.5 * static_cast<double>(sighting.frame), -4.6, 0.68});
    // What the blob held besides is in its sigma.
    EXPECT_LT((sighting.right->centre_px - truth_px).norm(),
              2.0 * sighting.right->centre_sigma_px.maxCoeff())
        << sighting.frame;
    EXPECT_EQ(has(sighting.right->defects, Defect::merged), sighting.frame < kSplit);
  }
}

TEST(HandOver, NotToALightElsewhereOrOfAnotherWidthOrSideOrVehicle) {
  const Road road;
  Lamp left = road.lamp(0, 50, -3.4, -3.4), old = road.lamp(0, 50, -4.6, -4.6);
  Vehicle vehicle, other;
  vehicle.left = &left;
  vehicle.right = &old;
  left.vehicle = old.vehicle = &vehicle;
  Lamp far = road.lamp(kSplit, 50, 0.0, -6.0), narrow = road.lamp(kSplit, 50, 0.0, -4.15);
  Lamp other_side = road.lamp(kSplit, 50, 0.0, -2.3);
  Lamp owned = road.lamp(kSplit, 50, 0.0, -4.65), first = road.lamp(0, 50, -4.65, -4.65);
  owned.vehicle = &other;
  for (Lamp* wrong : {&far, &narrow, &other_side, &owned, &first}) {
    EXPECT_FALSE(hand_over(vehicle, left, *wrong));
    EXPECT_EQ(vehicle.right, &old);
    EXPECT_EQ(old.records.size(), 51U);
  }
}

}  // namespace
}  // namespace vildar
