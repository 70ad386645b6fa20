#pragma once

#include <vector>

#include "estimate/simulated_pass.h"

namespace vildar::simulated {

/// What a site is really like, and how much of what a site file states of vehicles is common to
/// those of one site.
struct TrueSite {
  Site site;  ///< pose as it is; lengths: mean and spread of its vehicles
  double speed_low_mps = 8.0, speed_high_mps = 35.0;
};

/// A site drawn from what its file states: its pose and focal length from the priors, half of the
/// variance of each length common to its vehicles, half among them.
inline TrueSite true_site(const Site& stated, Random& random) {
  TrueSite truth{stated};
  CameraSite& camera = *truth.site.camera;
  for (Uncertain* turn_rad : {&camera.yaw_rad, &camera.pitch_rad, &camera.roll_rad})
    *turn_rad = {random.normal(turn_rad->mean, turn_rad->std), 0.0};
  if (camera.focal_std_px > 0.0) {
    const double factor = 1.0 + random.normal(0.0, camera.focal_std_px / camera.focal_px[0]);
    for (double& focal_px : camera.focal_px) focal_px *= factor;
    camera.focal_std_px = 0.0;
  }
  for (Uncertain* length_m : {&*truth.site.lamps.height_m, &*truth.site.lamps.separation_m,
                              &truth.site.road.lanes[0].lateral_m}) {
    const double half_std_m = std::sqrt(0.5) * length_m->std;
    *length_m = {random.normal(length_m->mean, half_std_m), half_std_m};
  }
  return truth;
}

struct TrueVehicle {
  Vehicle vehicle;
  VehicleTrack track;
};

inline Vehicle vehicle_of(const TrueSite& truth, Random& random) {
  const auto draw = [&](const Uncertain& value) { return random.normal(value.mean, value.std); };
  Vehicle vehicle;
  vehicle.speed_mps = random.uniform(truth.speed_low_mps, truth.speed_high_mps);
  vehicle.acceleration_mps2 = random.normal(0.0, 0.5);
  vehicle.lateral_m = draw(truth.site.road.lanes[0].lateral_m);
  vehicle.height_m = draw(*truth.site.lamps.height_m);
  vehicle.separation_m = draw(*truth.site.lamps.separation_m);
  return vehicle;
}

/// Passes of such vehicles, in view from 60 m until `to_m`.
inline std::vector<TrueVehicle> passes_of(const TrueSite& truth, int count, double to_m,
                                          Random& random) {
  std::vector<TrueVehicle> passes;
  for (int i = 0; i < count; ++i) {
    const Vehicle vehicle = vehicle_of(truth, random);
    const View view{.to_s = (vehicle.along_m - to_m) / vehicle.speed_mps};
    passes.push_back({vehicle, track_of(vehicle, truth.site, view, random)});
    passes.back().track.id = i + 1;
  }
  return passes;
}

inline std::vector<VehicleTrack> tracks_of(const std::vector<TrueVehicle>& passes) {
  std::vector<VehicleTrack> tracks;
  for (const TrueVehicle& pass : passes) tracks.push_back(pass.track);
  return tracks;
}

/// A mast whose pose is known roughly.
inline Site roughly_known_site(double camera_height_m, double turn_std_rad) {
  Site site = mast_site(camera_height_m);
  site.camera->yaw_rad.std = site.camera->pitch_rad.std = turn_std_rad;
  site.camera->roll_rad.std = 0.5 * turn_std_rad;
  return site;
}

}  // namespace vildar::simulated
