#include "estimate/lit_surface.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "estimate/vehicle.h"
#include "simulated_pass.h"

namespace vildar {
namespace {

using simulated::mast_site;
using simulated::track_of;
using simulated::Vehicle;
using simulated::View;

constexpr double kFocal_px = 1500.0, kCamera_m = 20.0;

CameraSite camera_of(double focal_px = kFocal_px) {
  CameraSite camera;
  camera.focal_px = {focal_px, focal_px};
  camera.position_m[0].mean = kCamera_m;
  return camera;
}

/// A light of this size from 45 to 25 m, as the picture shows it.
std::vector<TrackRow> rows_of(double width_m, double height_m, int saturated_px = 0) {
  std::vector<TrackRow> rows;
  for (int i = 0; i <= 20; ++i) {
    TrackRow row;
    const double away_m = 45.0 - i;
    row.range_m = kCamera_m + away_m;
    LampSighting lamp;
    const auto across = [&](double length_m) {
      return static_cast<int>(std::lround(length_m * kFocal_px / away_m)) - 1;
    };
    lamp.box = {100, 100, 100 + across(width_m), 100 + across(height_m)};
    lamp.saturated_px = saturated_px;
    row.sighting.left = lamp;
    rows.push_back(row);
  }
  return rows;
}

TEST(LitSurface, AWindowIsWiderThanAnyLamp) {
  const auto width_m = width_of_surface_m(rows_of(1.4, 0.9), camera_of());
  ASSERT_TRUE(width_m);
  EXPECT_NEAR(*width_m, 0.9, 0.03);
}

TEST(LitSurface, LampsAreNot) {
  EXPECT_FALSE(width_of_surface_m(rows_of(0.3, 0.3), camera_of()));
  EXPECT_FALSE(width_of_surface_m(rows_of(1.2, 0.15), camera_of()));  // a bar of light
  // What clips is drawn larger than it is.
  EXPECT_FALSE(width_of_surface_m(rows_of(0.9, 0.9, 40), camera_of()));
}

TEST(LitSurface, OfFewPixelsOrWithoutARangeNothingIsSaid) {
  EXPECT_FALSE(width_of_surface_m(rows_of(0.15, 0.15), camera_of(kFocal_px / 8.0)));
  std::vector<TrackRow> rows = rows_of(0.9, 0.9);
  for (TrackRow& row : rows) row.range_m.reset();
  EXPECT_FALSE(width_of_surface_m(rows, camera_of()));
}

TEST(LitSurface, HasNoSpeed) {
  const Site site = mast_site(5.0);
  Random random(7);
  View view{.to_s = 2.8, .sigma_px = 0.3};
  view.single_lamp = true;
  VehicleTrack track = track_of(Vehicle{.along_m = 70.0, .separation_m = 0.0}, site, view, random);
  ASSERT_FALSE(estimate_vehicle(track, site, {}).result.withheld);
  for (VehicleSighting& one : track.sightings) {
    one.left->saturated_px = 0;
    one.left->box = {0, 0, 59, 59};
  }
  EXPECT_EQ(estimate_vehicle(track, site, {}).result.withheld, Miss::not_on_road);
}

}  // namespace
}  // namespace vildar
