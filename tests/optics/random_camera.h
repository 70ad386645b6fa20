#pragma once

#include "core/quantity.h"
#include "core/random.h"
#include "types/site.h"

namespace vildar {

/// A camera such as is found at a road: any direction, lens distortion of the size that lenses
/// have.
inline CameraSite random_camera(Random& random, DistortionModel model) {
  CameraSite site;
  site.width_px = 1920;
  site.height_px = 1080;
  site.focal_px = {random.uniform(900.0, 2500.0), random.uniform(900.0, 2500.0)};
  site.principal_px = {random.uniform(900.0, 1000.0), random.uniform(500.0, 600.0)};
  site.distortion = model;
  if (model == DistortionModel::brown)
    site.distortion_coefficients = {random.uniform(-0.3, 0.1), random.uniform(0.0, 0.1),
                                    random.uniform(-1e-3, 1e-3), random.uniform(-1e-3, 1e-3),
                                    random.uniform(-0.01, 0.01)};
  if (model == DistortionModel::fisheye)
    site.distortion_coefficients = {random.uniform(-0.05, 0.05), random.uniform(-0.02, 0.02),
                                    random.uniform(-0.01, 0.01), random.uniform(-0.002, 0.002),
                                    0.0};
  for (Uncertain& coordinate : site.position_m) coordinate.mean = random.uniform(-3.0, 6.0);
  site.yaw_rad.mean = random.uniform(-kPi, kPi);
  site.pitch_rad.mean = random.uniform(-0.6, 0.6);
  site.roll_rad.mean = random.uniform(-0.3, 0.3);
  return site;
}

}  // namespace vildar
