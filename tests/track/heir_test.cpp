#include "track/heir.h"

#include <gtest/gtest.h>

#include "one_car.h"

namespace vildar {
namespace {

constexpr std::int64_t kSplit = 30;  // frame in which one blob becomes two

// The mast, and a light whose place across changes in the frame of the split.
struct SplitRoad : scene::OneCar {
  Lamp lamp(std::int64_t first, std::int64_t last, double y_m, double later_m) const {
    return OneCar::lamp(first, last,
                        [=](std::int64_t frame) { return frame < kSplit ? y_m : later_m; });
  }
};

TEST(HandOver, TheVehicleKeepsTheLampThatCameOutOfTheCommonBlob) {
  const SplitRoad road;
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
  EXPECT_EQ(old.sightings(), 51 - kSplit) << "what it was before tells nothing of a light alone";
  EXPECT_EQ(old.first_time(), old.records.front().time);

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
  const SplitRoad road;
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
