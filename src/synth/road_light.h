#pragma once

#include <vector>

#include "synth/background.h"
#include "synth/motion.h"

namespace vildar {

/// Light of the headlamps on the road as the camera sees it: illuminance of the ground times
/// what a dry (CIE R3) or wet (C2W3) road sends on, on a coarse grid of the image.
class RoadLight {
 public:
  RoadLight(GroundMap map, const Eigen::Vector3d& camera_m);

  /// For the vehicles at `time_s`; both lamps of a vehicle shine from their middle.
  void update(const Scenario& scenario, const std::vector<VehicleState>& states, double time_s);
  bool dark() const { return dark_; }
  /// Luminance along row `v`, `width` values, of a surface like asphalt; cd/m^2.
  void row(int v, int width, float* cd_per_m2) const;

 private:
  GroundMap map_;
  Eigen::Vector3d camera_m_;
  std::vector<float> light_;
  bool dark_ = true;
};

/// Illuminance of a ground point by one lamp pair that heads along `forward`; lx.
double ground_illuminance_lx(const LampBeam& beam, int lamps, const Eigen::Vector3d& lamp_m,
                             double heading_rad, double pitch_rad, const Eigen::Vector2d& point_m);

}  // namespace vildar
