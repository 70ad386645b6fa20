#include "track/pairing.h"

#include <memory>

#include <gtest/gtest.h>

#include "one_car.h"

namespace vildar {
namespace {

using Road = scene::OneCar;

// What is left of two vehicles after both were hidden: the left lamp of the one and the right lamp
// of the other, which go on as one vehicle's.
TEST(Pairing, WhatIsLeftOfTwoVehiclesBeginsAnewAsOne) {
  constexpr std::int64_t kBefore = 30, kLast = 60;
  const Road road;
  for (const bool two_lefts : {false, true}) {
    Lamps lamps;
    for (const double y_m : {-3.4, -4.6})
      lamps.push_back(std::make_unique<Lamp>(road.lamp(0, kBefore, y_m)));
    Vehicles vehicles;
    for (const auto& lamp : lamps) {
      const bool left = two_lefts || lamp == lamps.front();
      Vehicle& vehicle = *vehicles.emplace_back(std::make_unique<Vehicle>());
      (left ? vehicle.left : vehicle.right) = lamp.get();
      vehicle.both_seen = 20;
      vehicle.last_both = vehicle.last_good = 20;
      vehicle.last_both_time = Road::time_at(20);
      lamp->vehicle = &vehicle;
    }
    Pairing pairing(road.view);
    for (std::int64_t frame = kBefore + 1; frame <= kLast; ++frame) {
      for (const auto& lamp : lamps) {
        Blob blob;
        blob.centre_px = *road.camera.project(
            {70.0 - 0.5 * static_cast<double>(frame), lamp == lamps.front() ? -3.4 : -4.6, 0.68});
        blob.flux = 100.0;
        blob.kind = LampKind::headlamp;
        const Spot spot{&blob, *road.view.spot_from_pixel(blob.centre_px), 0.5, blob.centre_px,
                        blob.centre_sigma_px};
        lamp->predict(0.04, road.view);
        lamp->update(spot, frame, Road::time_at(frame));
      }
      pairing.update(lamps, vehicles, frame, Road::time_at(frame));
      for (const auto& vehicle : vehicles)
        ASSERT_TRUE(frame > kBefore + 10 || !vehicle->cut_after) << frame;
    }
    for (const auto& vehicle : vehicles) {
      ASSERT_EQ(vehicle->cut_after.has_value(), !two_lefts);
      EXPECT_EQ(vehicle->cut_after.value_or(20), 20);
    }
  }
}

}  // namespace
}  // namespace vildar
