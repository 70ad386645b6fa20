#include "estimate/side_light.h"

#include <cmath>
#include <cstdint>

#include <gtest/gtest.h>

#include "simulated_pass.h"

namespace vildar {
namespace {

using simulated::mast_site;
using simulated::track_of;
using simulated::Vehicle;
using simulated::View;

constexpr Vehicle kLorry{.along_m = 70.0, .lateral_m = -4.0, .height_m = 0.9, .separation_m = 2.0};
constexpr View kSeen{.to_s = 2.8, .sigma_px = 0.3};

// Lorries are among what the site expects; as far aside as its lights would be for motorcycles
// there are lanes.
Site lorry_site(double camera_x_m = 0.0) {
  Site site = mast_site(5.0);
  site.camera->position_m[0].mean = camera_x_m;
  site.lamps.separation_m = Uncertain{1.6, 0.4};
  site.road.lanes.push_back({"beside", {-6.5, 1.5}, 3.5, Direction::oncoming});
  return site;
}

VehicleEstimate estimated(int id, const Vehicle& vehicle, const View& view,
                          const Site& site = lorry_site()) {
  Random random(static_cast<std::uint64_t>(id));
  VehicleTrack track = track_of(vehicle, site, view, random);
  track.id = id;
  for (VehicleSighting& one : track.sightings)
    one.frame += std::lround(view.from_s * view.frame_rate_hz);
  VehicleEstimate found = estimate_vehicle(track, site, {});
  EXPECT_FALSE(found.result.withheld) << name_of(*found.result.withheld);
  return found;
}

// Behind the headlamps, and to the left of the middle.
VehicleEstimate light_at(double behind_m, double beside_m, View view = kSeen,
                         double faster_mps = 0.0, const Site& site = lorry_site()) {
  view.single_lamp = true;
  Vehicle light = kLorry;
  light.along_m += behind_m;
  light.lateral_m += beside_m;
  light.speed_mps += faster_mps;
  light.height_m = 1.1;
  light.separation_m = 0.0;
  return estimated(2, light, view, site);
}

TEST(SideLight, AMarkerKeepsItsPlaceOnTheSideOfALorry) {
  const VehicleEstimate lorry = estimated(1, kLorry, kSeen);
  for (const double behind_m : {3.0, 8.0, 15.0})
    for (const double beside_m : {-1.25, 1.25})
      EXPECT_TRUE(is_side_marker(light_at(behind_m, beside_m), lorry))
          << behind_m << ", " << beside_m;
}

TEST(SideLight, WhereverTheCameraStands) {
  for (const double camera_x_m : {-8.0, 8.0}) {
    const Site site = lorry_site(camera_x_m);
    const VehicleEstimate lorry = estimated(1, kLorry, kSeen, site);
    EXPECT_TRUE(is_side_marker(light_at(8.0, 1.25, kSeen, 0.0, site), lorry)) << camera_x_m;
    EXPECT_FALSE(is_side_marker(light_at(22.0, 1.25, kSeen, 0.0, site), lorry)) << camera_x_m;
  }
}

TEST(SideLight, AMarkerMayComeIntoViewBeforeTheLamps) {
  View later = kSeen, earlier = kSeen;
  later.from_s = 1.0;
  earlier.to_s = 0.95;
  const VehicleEstimate lorry = estimated(1, kLorry, later);
  EXPECT_TRUE(is_side_marker(light_at(3.0, 1.25, earlier), lorry));
}

TEST(SideLight, WhatFollowsOrDrivesBesideIsNoMarker) {
  const VehicleEstimate lorry = estimated(1, kLorry, kSeen);
  EXPECT_FALSE(is_side_marker(light_at(8.0, 0.4), lorry));
  EXPECT_FALSE(is_side_marker(light_at(8.0, -2.6), lorry));
  EXPECT_FALSE(is_side_marker(light_at(22.0, 1.25), lorry));
  EXPECT_FALSE(is_side_marker(light_at(-3.0, 1.25), lorry));
  EXPECT_FALSE(is_side_marker(light_at(12.0, 1.25, kSeen, -3.0), lorry));
  EXPECT_FALSE(is_side_marker(lorry, light_at(8.0, 1.25)));
}

// No car is so long: a motorcycle.
TEST(SideLight, FarBehindACarNothingIsOnItsSide) {
  Vehicle car = kLorry;
  car.separation_m = 1.3;
  const VehicleEstimate seen = estimated(1, car, kSeen);
  EXPECT_FALSE(is_side_marker(light_at(8.0, 0.9), seen));
  EXPECT_TRUE(is_side_marker(light_at(4.0, 0.9), seen));
}

}  // namespace
}  // namespace vildar
