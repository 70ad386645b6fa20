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

}  // namespace
}  // namespace vildar
