#include "track/aim.h"

#include <gtest/gtest.h>

#include "core/quantity.h"
#include "one_car.h"

namespace vildar {
namespace {

constexpr std::int64_t kWayFrames = 60;

/// A pair of lamps so far apart comes nearer before a mast; the site says of the camera's angles
/// what `told` makes of the truth.
std::optional<Site> learnt(double apart_m, const std::function<void(Site&)>& told,
                           std::int64_t frames = kWayFrames, double radius_m = INFINITY,
                           double roll_deg = 0.0) {
  scene::OneCar road;
  road.site.camera->roll_rad.mean = radians_from_degrees(roll_deg);
  road.view = RoadView(road.site);
  road.camera = Camera(*road.site.camera);
  Site site = road.site;
  told(site);
  Aim aim(site);
  std::optional<Site> last;
  for (std::int64_t frame = 12; frame <= frames; ++frame) {
    const auto at = [&](double y_m) {
      return [=](std::int64_t k) {
        const double ahead_m = 70.0 - 0.5 * static_cast<double>(k);
        return y_m + ahead_m * ahead_m / (2.0 * radius_m);
      };
    };
    Lamp left = road.lamp(frame - 12, frame, at(-4.0 + 0.5 * apart_m));
    Lamp right = road.lamp(frame - 12, frame, at(-4.0 - 0.5 * apart_m));
    left.id = 1;
    right.id = 2;
    Vehicles vehicles;
    vehicles.push_back(std::make_unique<Vehicle>(scene::vehicle_of(left, right)));
    if (auto site_now = aim.learn(vehicles, frame)) last = std::move(site_now);
  }
  return last;
}

void off_by_degrees(Site& site, double pitch_deg, double yaw_deg) {
  site.camera->pitch_rad.mean += radians_from_degrees(pitch_deg);
  site.camera->pitch_rad.std = radians_from_degrees(4.0);
  site.camera->yaw_rad.mean += radians_from_degrees(yaw_deg);
  site.camera->yaw_rad.std = radians_from_degrees(5.0);
}

TEST(Aim, OnePairTellsTheAnglesToWithinADegree) {
  const CameraSite truth = *scene::OneCar().site.camera;
  for (const double pitch_deg : {-5.0, 0.0, 5.0})
    for (const double yaw_deg : {-6.0, 6.0}) {
      const auto site = learnt(1.25, [&](Site& told) { off_by_degrees(told, pitch_deg, yaw_deg); });
      ASSERT_TRUE(site) << pitch_deg << ", " << yaw_deg;
      for (const auto& [found, is] : {std::pair(site->camera->pitch_rad, truth.pitch_rad.mean),
                                      std::pair(site->camera->yaw_rad, truth.yaw_rad.mean)}) {
        EXPECT_NEAR(degrees_from_radians(found.mean - is), 0.0, 0.7)
            << pitch_deg << ", " << yaw_deg;
        EXPECT_GE(degrees_from_radians(found.std), 1.0);
        EXPECT_LT(degrees_from_radians(found.std), 1.5);
      }
    }
}

TEST(Aim, OnABendThePitchAlone) {
  const auto site = learnt(
      1.25,
      [](Site& told) {
        off_by_degrees(told, 5.0, 6.0);
        told.road.kind = RoadKind::curved;
        told.road.radius_m = Uncertain{200.0, 20.0};
      },
      kWayFrames, 200.0);
  ASSERT_TRUE(site);
  EXPECT_LT(degrees_from_radians(site->camera->pitch_rad.std), 1.5);
  EXPECT_DOUBLE_EQ(degrees_from_radians(site->camera->yaw_rad.std), 5.0);
}

TEST(Aim, AKnownRollIsAllowedFor) {
  const CameraSite truth = *scene::OneCar().site.camera;
  for (const double roll_deg : {-8.0, 8.0}) {
    const auto site = learnt(
        1.25, [](Site& told) { off_by_degrees(told, 3.0, 6.0); }, kWayFrames, INFINITY, roll_deg);
    ASSERT_TRUE(site) << roll_deg;
    EXPECT_NEAR(degrees_from_radians(site->camera->pitch_rad.mean - truth.pitch_rad.mean), 0.0,
                0.7);
    EXPECT_NEAR(degrees_from_radians(site->camera->yaw_rad.mean - truth.yaw_rad.mean), 0.0, 0.7);
  }
}

// Lamps of two vehicles abreast, a way that is hardly begun, angles that are known, a dashcam.
TEST(Aim, WhatDoesNotTellIsNotTaken) {
  const auto off = [](Site& told) { off_by_degrees(told, 5.0, 6.0); };
  EXPECT_FALSE(learnt(3.5, off));
  EXPECT_FALSE(learnt(1.25, off, 20));
  EXPECT_FALSE(learnt(1.25, [](Site&) {}));
  EXPECT_FALSE(learnt(1.25, [&](Site& told) {
    off(told);
    told.ego = EgoSite{{15.0, 0.5}, {}, {}};
  }));
}

}  // namespace
}  // namespace vildar
