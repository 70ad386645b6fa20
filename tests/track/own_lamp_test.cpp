#include "track/own_lamp.h"

#include <gtest/gtest.h>

#include "one_car.h"

namespace vildar {
namespace {

using Road = scene::OneCar;

TEST(WasLampOf, ALightWhereTheVehicleMissedItsLamp) {
  const Road road;
  Lamp left = road.lamp(40, 60, -3.4), right = road.lamp(40, 60, -4.6);
  Vehicle vehicle = scene::vehicle_of(left, right);
  vehicle.past_left = road.lamp(0, 20, -3.4).records;
  vehicle.past_right = road.lamp(0, 20, -4.6).records;
  EXPECT_TRUE(was_lamp_of(road.lamp(22, 38, -4.6), vehicle, road.view));
  EXPECT_TRUE(was_lamp_of(road.lamp(22, 38, -3.4), vehicle, road.view));
  // A motorcycle between its lamps, one beside it, and a light after the vehicle was last seen.
  EXPECT_FALSE(was_lamp_of(road.lamp(22, 38, -4.0), vehicle, road.view));
  EXPECT_FALSE(was_lamp_of(road.lamp(22, 38, -5.8), vehicle, road.view));
  EXPECT_FALSE(was_lamp_of(road.lamp(59, 80, -4.6), vehicle, road.view));
}

TEST(WasLampOf, ALightShortlyBeforeTheVehicleShowedBothItsLamps) {
  const Road road;
  Lamp left = road.lamp(16, 60, -3.4), right = road.lamp(16, 60, -4.6);
  Vehicle vehicle = scene::vehicle_of(left, right);
  EXPECT_TRUE(was_lamp_of(road.lamp(2, 14, -4.6), vehicle, road.view));
  EXPECT_TRUE(was_lamp_of(road.lamp(2, 14, -3.4), vehicle, road.view));
  EXPECT_FALSE(was_lamp_of(road.lamp(2, 14, -4.0), vehicle, road.view));
  EXPECT_FALSE(was_lamp_of(road.lamp(2, 14, -4.6, 8.0), vehicle, road.view));
}

TEST(WasLampOf, ALightThatMadeAPairWithTheOneLampSeenOfTheVehicle) {
  const Road road;
  Lamp left = road.lamp(0, 80, -3.4), right = road.lamp(50, 80, -4.6);
  Vehicle vehicle = scene::vehicle_of(left, right);
  EXPECT_TRUE(was_lamp_of(road.lamp(0, 25, -4.6), vehicle, road.view));
  // One on its other side, one in the next lane and one 12 m nearer.
  EXPECT_FALSE(was_lamp_of(road.lamp(0, 25, -2.2), vehicle, road.view));
  EXPECT_FALSE(was_lamp_of(road.lamp(0, 25, -7.0), vehicle, road.view));
  EXPECT_FALSE(was_lamp_of(road.lamp(0, 25, -4.6, 12.0), vehicle, road.view));
}

TEST(WasLampOf, ALightThatWasForMostOfTheTimeThatTells) {
  const Road road;
  Lamp left = road.lamp(60, 80, -3.4), right = road.lamp(60, 80, -4.6);
  Vehicle vehicle = scene::vehicle_of(left, right);
  // Of its 41 frames those in which one lamp was seen of the vehicle tell.
  const auto light = [&](std::int64_t astray_from) {
    return road.lamp(0, 40, [=](std::int64_t frame) { return frame < astray_from ? -4.6 : -7.0; });
  };
  vehicle.past_left = road.lamp(0, 24, -3.4).records;
  EXPECT_TRUE(was_lamp_of(light(16), vehicle, road.view));
  EXPECT_FALSE(was_lamp_of(light(9), vehicle, road.view));
  vehicle.past_left = road.lamp(0, 15, -3.4).records;
  EXPECT_FALSE(was_lamp_of(light(16), vehicle, road.view)) << "too little time tells";
}

// Its left lamp is at the known car's left one until frame 25, then in the next lane; the right one
// is seen from frame 35 on.
struct Newcomer {
  Lamp left, right;
  Vehicle vehicle;
  explicit Newcomer(const Road& road)
      : left(road.lamp(10, 60, [](std::int64_t frame) { return frame <= 25 ? -3.4 : -7.0; })),
        right(road.lamp(35, 60, -8.2)),
        vehicle(scene::vehicle_of(left, right, 26)) {}
};

// Seen as a pair but for frames 10 to 39.
Vehicle known_at(const Road& road, double left_m, Lamp& left, Lamp& right) {
  left = road.lamp(40, 60, left_m);
  right = road.lamp(40, 60, left_m - 1.2);
  Vehicle known = scene::vehicle_of(left, right);
  known.past_left = road.lamp(0, 9, left_m).records;
  known.past_right = road.lamp(0, 9, left_m - 1.2).records;
  return known;
}

TEST(LastFrameAsAnother, UntilItsLampLeavesTheVehicleKnownBefore) {
  const Road road;
  const Newcomer found(road);
  Lamp left = road.lamp(0, 60, -3.4), right = road.lamp(0, 60, -4.6);
  const Vehicle known = known_at(road, -3.4, left, right);
  EXPECT_EQ(last_frame_as_another(found.vehicle, {&known}, road.view), 25);
  EXPECT_EQ(last_frame_as_another(found.vehicle, {}, road.view), std::nullopt);
  // The last of several, whichever it was.
  Lamp beside_left = left, beside_right = right;
  const Vehicle beside = known_at(road, -7.1, beside_left, beside_right);
  EXPECT_EQ(last_frame_as_another(found.vehicle, {&known, &beside}, road.view), 34);
  EXPECT_EQ(last_frame_as_another(found.vehicle, {&beside, &known}, road.view), 34);
  // With its right lamp alone seen, the light made a pair with that.
  Vehicle half = known;
  half.past_right = road.lamp(0, 39, -4.6).records;
  EXPECT_EQ(last_frame_as_another(found.vehicle, {&half}, road.view), 25);
  // With both seen, it is a third light.
  half.past_left = road.lamp(0, 39, -3.4).records;
  EXPECT_EQ(last_frame_as_another(found.vehicle, {&half}, road.view), std::nullopt);
}

TEST(LastFrameAsAnother, NotOneKnownLater) {
  const Road road;
  const Newcomer found(road);
  for (const std::int64_t first_pair : {30, 36}) {
    Lamp left = road.lamp(0, 60, -3.4), right = road.lamp(first_pair, 60, -4.6);
    const Vehicle other = scene::vehicle_of(left, right);
    EXPECT_EQ(last_frame_as_another(found.vehicle, {&other}, road.view).has_value(),
              first_pair == 30);
  }
}

TEST(LastFrameAsAnother, NothingUpToItIsTheVehicles) {
  const Road road;
  Newcomer found(road);
  found.vehicle.last_as_another = 25;
  VehicleTrack track;
  ASSERT_EQ(judge_vehicle(found.vehicle, road.view, {}, {}, track), Verdict::vehicle);
  EXPECT_EQ(track.sightings.front().frame, 26);
  EXPECT_EQ(track.sightings.back().frame, 60);
}

// The right lamp of the first car is followed on that of the second until this one, seen as a pair
// before, goes dark.
TEST(LastFrameAsAnother, TheTrackerLeavesItOut) {
  scene::Scene made;
  made.site = scene::site_of(5.0, -4.0, 1400.0, 1920, 1080);
  made.cars.resize(2);
  made.cars[0].x_m = 61.0;
  made.cars[0].speed_mps = -16.5;
  made.cars[0].left_hidden_from_s = 0.72;
  made.cars[0].left_hidden_to_s = 2.76;
  made.cars[0].hidden_s = {{0.04, 1.4}};
  made.cars[1].x_m = 63.5;
  made.cars[1].speed_mps = -18.5;
  made.cars[1].left_hidden_from_s = 0.16;
  made.cars[1].left_hidden_to_s = 2.4;
  made.cars[1].hidden_s = {{1.2, 1.72}};
  const auto outcome = scene::run(made);
  ASSERT_EQ(outcome.tracks.size(), 2U);
  EXPECT_EQ(outcome.tracks_of(0), 1);
  EXPECT_EQ(outcome.tracks_of(1), 1);
  EXPECT_GE(outcome.recall(0), 0.5) << "for some frames the two are in one place";
}

}  // namespace
}  // namespace vildar
