#pragma once

#include <gtest/gtest.h>

#include <cmath>

#include "estimate/vehicle.h"
#include "simulated_pass.h"

namespace vildar::simulated {

// Without noise and with the priors' means at the truth, only the solver's tolerance is left.
inline constexpr double kExact = 1e-6;
inline constexpr View kNoiseless{.frame_rate_hz = 15.0, .sigma_px = 1e-7};
inline constexpr Vehicle kTypical{20.0, 0.0, 60.0, -4.0, 0.65, 1.2};

inline VehicleResult result_of(const Vehicle& vehicle, const Site& site, const View& view) {
  Random random(1);
  return estimate_vehicle(track_of(vehicle, site, view, random), site, {}).result;
}

inline void expect_motion(const VehicleResult& result, const Vehicle& vehicle, double tolerance) {
  ASSERT_FALSE(result.withheld) << name_of(*result.withheld);
  const double t_s = result.speed.time_s;
  EXPECT_NEAR(result.speed.speed_mps / std::abs(vehicle.speed_at_mps(t_s)), 1.0, tolerance);
  EXPECT_LE(result.speed.lo95_mps, result.speed.speed_mps);
  EXPECT_GE(result.speed.hi95_mps, result.speed.speed_mps);
  EXPECT_EQ(result.method, Method::geometry_camera);
}

}  // namespace vildar::simulated
