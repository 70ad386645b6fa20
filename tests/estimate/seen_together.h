#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <gtest/gtest.h>

#include "estimate/vehicle.h"
#include "simulated_pass.h"

namespace vildar::seen_together {

using simulated::mast_site;
using simulated::track_of;
using simulated::Vehicle;
using simulated::View;

inline constexpr double kLampHeight_m = 0.68, kOverLamps_m = 5.0 - kLampHeight_m;
inline constexpr Vehicle kCar{.along_m = 70.0};
inline constexpr View kLong{.to_s = 2.8, .sigma_px = 0.3};

enum class Frames { all, even, odd };

/// Measured, of some of the frames in which it is in view.
inline VehicleEstimate estimate_of(int id, const Vehicle& vehicle, Frames frames,
                                   const View& view = kLong, const Site& site = mast_site(5.0)) {
  Random random(static_cast<std::uint64_t>(id));
  VehicleTrack track = track_of(vehicle, site, view, random);
  track.id = id;
  for (VehicleSighting& one : track.sightings)
    one.frame += std::lround(view.from_s * view.frame_rate_hz);
  std::erase_if(track.sightings, [&](const VehicleSighting& one) {
    return frames != Frames::all && one.frame % 2 != (frames == Frames::odd);
  });
  VehicleEstimate estimate = estimate_vehicle(track, site, {});
  EXPECT_FALSE(estimate.result.withheld) << name_of(*estimate.result.withheld);
  return estimate;
}

inline Vehicle moved(Vehicle vehicle, double along_m, double lateral_m) {
  vehicle.along_m += along_m;
  vehicle.lateral_m += lateral_m;
  return vehicle;
}

inline View lone() {
  View view = kLong;
  view.single_lamp = true;
  return view;
}

/// Lamps this high on the car, `back_m` behind its headlamps, as far apart as a car's would seem
/// where their elevation puts them.
inline Vehicle roof_lamps(double height_m, double back_m) {
  Vehicle lamps = moved(kCar, back_m, 0.0);
  lamps.height_m = height_m;
  lamps.separation_m = kCar.separation_m * (5.0 - height_m) / kOverLamps_m;
  return lamps;
}

}  // namespace vildar::seen_together
