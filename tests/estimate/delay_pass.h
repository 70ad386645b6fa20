#pragma once

#include <array>
#include <cmath>
#include <utility>

#include "simulated_beam.h"

namespace vildar::simulated {

/// Two photodiodes on masts of 4 m, `baseline_m` apart along a straight road; no camera.
inline Site two_photodiodes(double baseline_m, double gain_std = 0.002,
                            double baseline_std_m = 0.0) {
  Site site = mast_site(4.0);
  site.camera.reset();
  site.photodiodes.resize(2);
  for (int k = 0; k < 2; ++k) {
    PhotodiodeSite& photodiode = site.photodiodes[static_cast<std::size_t>(k)];
    photodiode.id = "pd" + std::to_string(k);
    photodiode.position_m = {Uncertain{baseline_m * k, k * baseline_std_m}, Uncertain{0.0, 0.0},
                             Uncertain{4.0, 0.0}};
  }
  site.photodiodes[1].gain_ratio = {1.0, gain_std};
  return site;
}

/// A vehicle that does not stop within the 60 m before the masts.
inline Vehicle random_vehicle(double acceleration_std_mps2, Random& random) {
  Vehicle vehicle;
  vehicle.speed_mps = random.uniform(8.0, 35.0);
  vehicle.acceleration_mps2 = random.normal(0.0, acceleration_std_mps2);
  const double hardest_mps2 = vehicle.speed_mps * vehicle.speed_mps / 150.0;
  if (vehicle.acceleration_mps2 < -hardest_mps2)
    vehicle.acceleration_mps2 = -vehicle.acceleration_mps2;
  vehicle.lateral_m = random.normal(-4.0, 0.3);
  vehicle.height_m = random.normal(0.65, 0.1);
  vehicle.separation_m = random.normal(1.2, 0.15);
  return vehicle;
}

/// A vehicle that drives on past the masts and whose acceleration wanders, as the estimator takes
/// it to do: most cruise, a few brake hard. `wander_mps2_per_root_s` becomes how much this one
/// does.
inline Vehicle wandering_vehicle(Random& random, double& wander_mps2_per_root_s) {
  constexpr std::array<std::pair<double, double>, 5> kShares{
      {{0.05, 0.4}, {0.4, 0.25}, {1.0, 0.2}, {2.5, 0.1}, {6.0, 0.05}}};
  constexpr int kSteps = 16;
  constexpr double kSlowest_mps = 2.0, kHardest_mps2 = 9.0, kHardestUp_mps2 = 5.0;
  for (;;) {
    Vehicle vehicle = random_vehicle(1.5, random);
    double drawn = random.uniform();
    for (const auto& [mps2_per_root_s, share] : kShares) {
      wander_mps2_per_root_s = mps2_per_root_s;
      if ((drawn -= share) < 0.0) break;
    }
    // As much before as in view: the prior holds where the light is brightest.
    vehicle.acceleration_mps2 = random.normal(0.0, std::hypot(1.5, wander_mps2_per_root_s));
    const double between_s = vehicle.along_m / vehicle.speed_mps / (kSteps + 1);
    for (int k = 1; k <= kSteps; ++k) {
      const double step_mps2 = random.normal(0.0, wander_mps2_per_root_s * std::sqrt(between_s));
      vehicle.changes.push_back({k * between_s, step_mps2});
      vehicle.acceleration_mps2 -= step_mps2;
    }
    bool drives = true;
    double now_mps2 = vehicle.acceleration_mps2;
    for (const AccelerationChange& change : vehicle.changes) {
      drives &= now_mps2 > -kHardest_mps2 && now_mps2 < kHardestUp_mps2 &&
                vehicle.speed_at_mps(change.at_s) > kSlowest_mps;
      now_mps2 += change.mps2;
    }
    constexpr double kLatest_s = 7.5;
    drives &=
        vehicle.speed_at_mps(kLatest_s) > kSlowest_mps || vehicle.along_at_m(kLatest_s) < -5.0;
    if (drives) return vehicle;
  }
}

}  // namespace vildar::simulated
