#include <cstdint>

#include <gtest/gtest.h>

#include "estimate/flashers.h"
#include "estimate/vehicle.h"
#include "simulated_pass.h"

namespace vildar {
namespace {

using simulated::mast_site;
using simulated::track_of;
using simulated::Vehicle;
using simulated::View;

constexpr View kAlone{.to_s = 2.8, .sigma_px = 0.1, .single_lamp = true};
constexpr Vehicle kSlowMotorcycle{.speed_mps = 14.0, .along_m = 65.0, .separation_m = 0.0};
constexpr int kCycle = 20;  // frames

// Lit for seven frames in twenty.
VehicleTrack blinking(const Site& site, bool stands) {
  Random random(1);
  VehicleTrack track = track_of(kSlowMotorcycle, site, kAlone, random);
  const std::vector<VehicleSighting> all = track.sightings;
  track.sightings.clear();
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (i % kCycle >= 7) continue;
    VehicleSighting seen = all[i];
    const VehicleSighting& first = all[i - i % kCycle];
    if (stands && seen.left) seen.left = first.left;
    if (stands && seen.right) seen.right = first.right;
    track.sightings.push_back(seen);
  }
  return track;
}

TEST(StandingLights, LitOneAfterAnotherAreNoVehicle) {
  const Site site = mast_site(5.0);
  const VehicleEstimate lights = estimate_vehicle(blinking(site, true), site, {});
  EXPECT_EQ(lights.result.withheld, Miss::not_on_road);
  EXPECT_TRUE(lit_in_turn(blinking(site, true)));
  const VehicleEstimate vehicle = estimate_vehicle(blinking(site, false), site, {});
  EXPECT_FALSE(vehicle.result.withheld);
}

}  // namespace
}  // namespace vildar
