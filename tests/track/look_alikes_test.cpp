#include "track/look_alikes.h"

#include <functional>
#include <memory>
#include <optional>

#include <gtest/gtest.h>

#include "one_car.h"

namespace vildar {
namespace {

// A lamp of flux 100 that comes nearer, and its image on a wet road.
Lamps lamp_and_image(const scene::OneCar& road, std::int64_t frames, double image_flux,
                     const PixelBox& image_box, bool casts_image, double image_m = -0.68) {
  Lamps lamps;
  for (const bool image : {false, true})
    for (std::int64_t frame = 0; frame < frames; ++frame) {
      Blob blob;
      blob.centre_px = *road.camera.project(
          {70.0 - 0.5 * static_cast<double>(frame), -4.0, image ? image_m : 0.68});
      blob.flux = image ? image_flux : 100.0;
      blob.box = image ? image_box : PixelBox{0, 0, 4, 4};
      blob.kind = LampKind::headlamp;
      Spot spot{&blob, *road.view.spot_from_pixel(blob.centre_px), 0.5, blob.centre_px,
                blob.centre_sigma_px};
      spot.casts_image = casts_image;
      if (frame == 0) {
        lamps.push_back(std::make_unique<Lamp>(spot, road.view.place(spot.at_px), frame,
                                               road.time_at(frame), road.view));
      } else {
        lamps.back()->predict(0.04, road.view);
        lamps.back()->update(spot, frame, road.time_at(frame));
      }
    }
  return lamps;
}

// The streak of a lamp may be seen as several lights, of which the upper ones have light below
// them.
TEST(LookAlikes, WhatStandsWhereAMirrorShowsALampHasNoImageItself) {
  const scene::OneCar road;
  constexpr std::int64_t kFrames = 10;
  const Lamps lamps = lamp_and_image(road, kFrames, 50.0, {}, true);
  note_look_alikes(lamps, {}, {}, road.view, kFrames - 1);
  EXPECT_TRUE(lamps[0]->records.back().casts_image);
  EXPECT_FALSE(lamps[1]->records.back().casts_image);
}

// With more light than the lamp it is one where the road draws it out, and a lamp of its own where
// it is as small.
TEST(LookAlikes, AnImageMayHaveMoreLightThanItsLampButNoBrighterPixel) {
  const scene::OneCar road;
  constexpr std::int64_t kFrames = 10;
  for (const bool drawn_out : {true, false}) {
    const Lamps lamps = lamp_and_image(road, kFrames, 180.0, {0, 0, 4, drawn_out ? 14 : 4}, false);
    note_look_alikes(lamps, {}, {}, road.view, kFrames - 1);
    EXPECT_EQ(lamps[1]->mirrored.share() > 0.5, drawn_out);
    EXPECT_EQ(lamps[0]->mirrored.share(), 0.0);
  }
}

// The road draws images out toward the viewer, to more than three lamp heights below a lamp; what
// is there and as small as a lamp is one.
TEST(LookAlikes, ADrawnOutImageMayStandFartherBelowItsLampThanAMirrorShowsIt) {
  constexpr double kBelow_m = 3.05 * 0.68, kFaint = 50.0;
  const scene::OneCar road;
  constexpr std::int64_t kFrames = 10;
  for (const int height_px : {4, 14}) {
    const Lamps lamps =
        lamp_and_image(road, kFrames, kFaint, {0, 0, 4, height_px}, false, 0.68 - kBelow_m);
    note_look_alikes(lamps, {}, {}, road.view, kFrames - 1);
    EXPECT_EQ(lamps[1]->mirrored.share() > 0.5, height_px > 4) << height_px;
  }
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

// A lamp that is at `at_m(frame)` in the world, followed from frame 0 to `last`.
Lamp followed(const scene::OneCar& road, std::int64_t last, double flux,
              const std::function<Eigen::Vector3d(std::int64_t)>& at_m, std::int64_t first = 0) {
  std::optional<Lamp> lamp;
  for (std::int64_t frame = first; frame <= last; ++frame) {
    Blob blob;
    blob.centre_px = *road.camera.project(at_m(frame));
    blob.flux = flux;
    blob.kind = LampKind::headlamp;
    const Spot spot{&blob, *road.view.spot_from_pixel(blob.centre_px), 0.5, blob.centre_px,
                    blob.centre_sigma_px};
    if (!lamp) {
      lamp.emplace(spot, road.view.place(spot.at_px), frame, road.time_at(frame), road.view);
    } else {
      lamp->predict(0.04, road.view);
      lamp->update(spot, frame, road.time_at(frame));
    }
  }
  return *lamp;
}

double along_m(std::int64_t frame) { return 70.0 - 0.5 * static_cast<double>(frame); }

// A light between a pair's lamps, `above_m` over them and `behind_m` farther away, which is first
// seen when they are or, so many frames, earlier.
double riding_share(double above_m, double behind_m, std::int64_t earlier = 0) {
  const scene::OneCar road;
  constexpr std::int64_t kFrames = 80;
  const auto lamp_at = [&](double y_m, double over_m, double back_m, std::int64_t first) {
    return followed(
        road, kFrames, 100.0,
        [=](std::int64_t frame) {
          return Eigen::Vector3d(along_m(frame) + back_m, y_m, 0.68 + over_m);
        },
        first);
  };
  Lamp left = lamp_at(-3.4, 0.0, 0.0, earlier), right = lamp_at(-4.6, 0.0, 0.0, earlier);
  const PairFit fit = road.view.fit_pair(left.at_px(), right.at_px(), 1.0);
  Lamps lamps;
  lamps.push_back(std::make_unique<Lamp>(lamp_at(-4.0, above_m, behind_m, 0)));
  Vehicles vehicles;
  vehicles.push_back(std::make_unique<Vehicle>(scene::vehicle_of(left, right)));
  vehicles[0]->inverse_depth_per_m = fit.inverse_depth_per_m;
  vehicles[0]->width_per_depth = fit.width_per_depth;
  note_look_alikes(lamps, {}, vehicles, road.view, kFrames);
  return lamps[0]->on_vehicle.share();
}

// A lamp 20 m behind the pair is seen over its roof, where it was over its bonnet before.
TEST(LookAlikes, WhatRidesOnABodyKeepsItsPlaceThere) {
  EXPECT_EQ(riding_share(1.4, 0.0), 1.0);
  EXPECT_EQ(riding_share(0.8, 3.0), 1.0) << "behind the windscreen";
  EXPECT_EQ(riding_share(0.0, 20.0), 0.0);
  EXPECT_EQ(riding_share(0.0, 14.0), 0.0);
  EXPECT_EQ(riding_share(0.0, 14.0, 15), 0.0);
  EXPECT_EQ(riding_share(1.4, 0.0, 15), 1.0);
}

// A light that seems at lamp height and `nearer` times as near as the lamps, in the column of one
// at y_m.
Lamp light_below(const scene::OneCar& road, std::int64_t last, double y_m, double nearer) {
  return followed(road, last, 50.0, [=](std::int64_t frame) {
    return Eigen::Vector3d(along_m(frame) / nearer, y_m / nearer, 0.68);
  });
}

// Of light on the road from the lamp all the way to the camera, what is four lamp heights below the
// lamp in the picture, farther than its mirror image.
double glint_nearer(const scene::OneCar& road) {
  return 1.0 + 2.7 / road.view.height_over_lamps_m();
}

// The third lamp, as far below, is of a vehicle in the next lane.
TEST(LookAlikes, WhatKeepsToALampsColumnIsNoticed) {
  const scene::OneCar road;
  constexpr std::int64_t kFrames = 10;
  Lamps lamps;
  lamps.push_back(std::make_unique<Lamp>(road.lamp(0, kFrames, -4.0)));
  for (const double y_m : {-4.0, -7.5})
    lamps.push_back(std::make_unique<Lamp>(light_below(road, kFrames, y_m, glint_nearer(road))));
  note_look_alikes(lamps, {}, {}, road.view, kFrames);
  EXPECT_EQ(lamps[0]->below.share(), 0.0);
  EXPECT_EQ(lamps[1]->below.share(), 1.0);
  EXPECT_EQ(lamps[2]->below.share(), 0.0);
}

// The ends of a pair's streaks flicker: now one is seen, now the other.
TEST(LookAlikes, ThePairBelowALampsPairIsItsImageWhereOneOfItIsSeenToo) {
  const scene::OneCar road;
  constexpr std::int64_t kFrames = 10;
  for (const double beside_m : {0.0, 3.5}) {
    Lamp left = road.lamp(0, kFrames, -3.4), right = road.lamp(0, kFrames, -4.6);
    Lamp lower_left = light_below(road, kFrames, -3.4 - beside_m, glint_nearer(road));
    Lamp lower_right = light_below(road, kFrames - 2, -4.6 - beside_m, glint_nearer(road));
    Vehicles vehicles;
    vehicles.push_back(std::make_unique<Vehicle>(scene::vehicle_of(left, right)));
    vehicles.push_back(std::make_unique<Vehicle>(scene::vehicle_of(lower_left, lower_right)));
    for (const auto& vehicle : vehicles) vehicle->width_per_depth = 1.2 / 65.0;
    vehicles[0]->inverse_depth_per_m = 1.0 / 65.0;
    vehicles[1]->inverse_depth_per_m = glint_nearer(road) / 65.0;
    note_look_alikes({}, {}, vehicles, road.view, kFrames);
    EXPECT_EQ(vehicles[1]->looks, 1);
    EXPECT_EQ(vehicles[1]->images, beside_m == 0.0 ? 1 : 0);
    EXPECT_EQ(vehicles[0]->images, 0);
  }
}

}  // namespace
}  // namespace vildar
