#include "track/own_lamp.h"

#include <gtest/gtest.h>

#include "optics/camera.h"
#include "scene.h"

namespace vildar {
namespace {

// Before a mast: a car that comes nearer by half a metre a frame, its lamps at -3.4 and -4.6 m.
struct Road {
  Site site = scene::site_of(5.0, -4.0, 1400.0, 1920, 1080);
  RoadView view{site};
  Camera camera{*site.camera};

  Lamp lamp(std::int64_t first, std::int64_t last, double y_m) const {
    std::optional<Lamp> made;
    for (std::int64_t frame = first; frame <= last; ++frame) {
      Blob blob;
      blob.centre_px = *camera.project({70.0 - 0.5 * static_cast<double>(frame), y_m, 0.68});
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

TEST(WasLampOf, ALightWhereTheVehicleMissedItsLamp) {
  const Road road;
  Lamp left = road.lamp(40, 60, -3.4), right = road.lamp(40, 60, -4.6);
  Vehicle vehicle;
  vehicle.left = &left;
  vehicle.right = &right;
  vehicle.past_left = road.lamp(0, 20, -3.4).records;
  vehicle.past_right = road.lamp(0, 20, -4.6).records;
  EXPECT_TRUE(was_lamp_of(road.lamp(22, 38, -4.6), vehicle, road.view));
  EXPECT_TRUE(was_lamp_of(road.lamp(22, 38, -3.4), vehicle, road.view));
  // A motorcycle between its lamps, one beside it, and a light after the vehicle was last seen.
  EXPECT_FALSE(was_lamp_of(road.lamp(22, 38, -4.0), vehicle, road.view));
  EXPECT_FALSE(was_lamp_of(road.lamp(22, 38, -5.8), vehicle, road.view));
  EXPECT_FALSE(was_lamp_of(road.lamp(59, 80, -4.6), vehicle, road.view));
}

}  // namespace
}  // namespace vildar
