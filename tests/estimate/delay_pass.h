#pragma once

#include <cmath>

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

}  // namespace vildar::simulated
