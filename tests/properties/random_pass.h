#pragma once

#include <rapidcheck.h>

#include "estimate/simulated_pass.h"
#include "estimate/vehicle.h"

namespace vildar::properties {

/// A number between the two, in steps of a thousandth of their distance.
inline double between(double low, double high) {
  return low + (high - low) * *rc::gen::inRange(0, 1001) / 1000.0;
}

/// A camera beside or over a road, a vehicle that comes, and what the camera reports of it.
struct Pass {
  Site site;
  simulated::Vehicle vehicle;
  simulated::View view;
  VehicleTrack track;
};

inline Pass random_pass(double sigma_px, bool may_be_curved) {
  Pass pass;
  pass.site = simulated::mast_site(between(3.0, 8.0));
  CameraSite& camera = *pass.site.camera;
  camera.yaw_rad.mean = between(-0.08, 0.08);
  camera.pitch_rad.mean = between(-0.12, -0.04);
  camera.roll_rad.mean = between(-0.05, 0.05);
  camera.principal_px = {between(900.0, 1000.0), between(500.0, 580.0)};
  camera.distortion = DistortionModel::brown;
  camera.distortion_coefficients = {between(-0.2, 0.0), between(0.0, 0.05), between(-1e-3, 1e-3),
                                    between(-1e-3, 1e-3), 0.0};
  camera.rolling_shutter_s = between(0.0, 0.02);
  pass.vehicle.speed_mps = between(12.0, 32.0);
  pass.vehicle.along_m = between(60.0, 90.0);
  pass.vehicle.lateral_m = between(-6.0, -2.0);
  pass.vehicle.height_m = 0.65;
  pass.vehicle.separation_m = 1.2;
  LaneSite& lane = pass.site.road.lanes.front();
  lane.lateral_m.mean = pass.vehicle.lateral_m;
  if (may_be_curved && *rc::gen::arbitrary<bool>()) {
    pass.site.road.kind = RoadKind::curved;
    pass.site.road.turn = *rc::gen::element(Turn::left, Turn::right);
    pass.site.road.radius_m = Uncertain{between(150.0, 400.0), 0.0};
    pass.site.road.straight_m.mean = between(0.0, 20.0);
  }
  pass.view.frame_rate_hz = 15.0;
  pass.view.sigma_px = sigma_px;
  pass.view.to_s = 0.75 * pass.vehicle.along_m / pass.vehicle.speed_mps;
  Random random(static_cast<std::uint64_t>(*rc::gen::inRange(1, 1'000'000)));
  pass.track = simulated::track_of(pass.vehicle, pass.site, pass.view, random);
  return pass;
}

/// Whether two numbers agree to a share of their size, or of one for small ones.
inline bool agree(double a, double b, double tolerance) {
  return std::abs(a - b) <= tolerance * std::max({1.0, std::abs(a), std::abs(b)});
}

}  // namespace vildar::properties
