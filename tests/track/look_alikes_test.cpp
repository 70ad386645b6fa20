#include "track/look_alikes.h"

#include <memory>
#include <optional>

#include <gtest/gtest.h>

#include "one_car.h"

namespace vildar {
namespace {

// The streak of a lamp may be seen as several lights, of which the upper ones have light below
// them.
TEST(LookAlikes, WhatStandsWhereAMirrorShowsALampHasNoImageItself) {
  const scene::OneCar road;
  constexpr std::int64_t kFrames = 10;
  Lamps lamps;
  for (const double height_m : {0.68, -0.68}) {
    for (std::int64_t frame = 0; frame < kFrames; ++frame) {
      Blob blob;
      blob.centre_px =
          *road.camera.project({70.0 - 0.5 * static_cast<double>(frame), -4.0, height_m});
      blob.flux = height_m > 0.0 ? 100.0 : 50.0;
      blob.kind = LampKind::headlamp;
      Spot spot{&blob, *road.view.spot_from_pixel(blob.centre_px), 0.5, blob.centre_px,
                blob.centre_sigma_px};
      spot.casts_image = true;
      if (frame == 0) {
        lamps.push_back(std::make_unique<Lamp>(spot, road.view.place(spot.at_px), frame,
                                               road.time_at(frame), road.view));
      } else {
        lamps.back()->predict(0.04, road.view);
        lamps.back()->update(spot, frame, road.time_at(frame));
      }
    }
  }
  note_look_alikes(lamps, {}, {}, road.view, kFrames - 1);
  EXPECT_TRUE(lamps[0]->records.back().casts_image);
  EXPECT_FALSE(lamps[1]->records.back().casts_image);
}

// Where the lamp above it is not known, the top of a streak is taken for a lamp with its own.
TEST(LookAlikes, ALoneLightWithinAStreakIsTheStreaks) {
  const scene::OneCar road;
  constexpr std::int64_t kFrames = 10;
  for (const int beside_px : {0, 20}) {
    Lamps lamps;
    lamps.push_back(std::make_unique<Lamp>(road.lamp(0, kFrames - 2, -4.0)));
    lamps.front()->predict(0.04, road.view);
    Blob blob;
    const Eigen::Vector2d down_px(beside_px, 10.0);  // from the top to the middle
    blob.box = {0, 0, 6, 24};
    Spot streak{&blob, lamps.front()->at_px() + down_px};
    streak.streak = true;
    note_look_alikes(lamps, {streak}, {}, road.view, kFrames - 1);
    EXPECT_EQ(lamps.front()->reflected.looks(), beside_px == 0 ? 1 : 0);
  }
}

// Lane paint that lamps light, which at lamp height would be 16 m and is on the road 8 m before
// them.
TEST(LookAlikes, ALightFarFainterThanTheLampsBehindItIsWhatTheyLight) {
  const scene::OneCar road;
  constexpr std::int64_t kFrames = 10;
  for (const double fainter : {2.0, 30.0}) {
    Lamps lamps;
    for (const double y_m : {-3.4, -4.6})
      lamps.push_back(std::make_unique<Lamp>(road.lamp(0, kFrames, y_m)));
    lamps.push_back(std::make_unique<Lamp>(road.lamp(0, kFrames, -4.0, 16.0, 100.0 / fainter)));
    note_look_alikes(lamps, {}, {}, road.view, kFrames);
    EXPECT_EQ(lamps.back()->on_vehicle.share(), fainter > 10.0 ? 1.0 : 0.0) << fainter;
    EXPECT_EQ(lamps.front()->on_vehicle.share(), 0.0);
  }
}

// Light on the road all the way from the lamp to the camera, four lamp heights below the lamp in
// the picture, farther than its mirror image.
// The third lamp, as far below, is of a vehicle in the next lane.
TEST(LookAlikes, WhatKeepsToALampsColumnIsNoticed) {
  const scene::OneCar road;
  constexpr std::int64_t kFrames = 10;
  Lamps lamps;
  lamps.push_back(std::make_unique<Lamp>(road.lamp(0, kFrames, -4.0)));
  const double nearer = 1.0 + 2.7 / road.view.height_over_lamps_m();
  for (const double y_m : {-4.0 / nearer, -7.5 / nearer}) {
    std::optional<Lamp> light;
    for (std::int64_t frame = 0; frame <= kFrames; ++frame) {
      Blob blob;
      const double x_m = (70.0 - 0.5 * static_cast<double>(frame)) / nearer;
      blob.centre_px = *road.camera.project({x_m, y_m, 0.68});
      blob.flux = 50.0;
      blob.kind = LampKind::headlamp;
      const Spot spot{&blob, *road.view.spot_from_pixel(blob.centre_px), 0.5, blob.centre_px,
                      blob.centre_sigma_px};
      if (!light) {
        light.emplace(spot, road.view.place(spot.at_px), frame, road.time_at(frame), road.view);
      } else {
        light->predict(0.04, road.view);
        light->update(spot, frame, road.time_at(frame));
      }
    }
    lamps.push_back(std::make_unique<Lamp>(*light));
  }
  note_look_alikes(lamps, {}, {}, road.view, kFrames);
  EXPECT_EQ(lamps[0]->below.share(), 0.0);
  EXPECT_EQ(lamps[1]->below.share(), 1.0);
  EXPECT_EQ(lamps[2]->below.share(), 0.0);
}

}  // namespace
}  // namespace vildar
