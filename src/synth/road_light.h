#pragma once

#include <vector>

#include "synth/background.h"
#include "synth/motion.h"

namespace vildar {

/// Light of headlamps and street lamps on the road as the camera sees it: illuminance of the ground
/// times what a dry (CIE R3) or wet (C2W3) road sends on, on a coarse grid of the image.
class RoadLight {
 public:
  RoadLight(GroundMap map, const Eigen::Vector3d& camera_m);

  /// For the vehicles at `time_s`, the middle of the picture's exposure; both lamps of a vehicle
  /// shine from their middle. Street lamps shine alike in all directions below them, with the
  /// flicker of the rows' own times.
  void update(const Scenario& scenario, const std::vector<VehicleState>& states, double time_s);
  bool dark() const { return dark_; }
  /// Luminance along row `v`, `width` values, of a surface like asphalt; cd/m^2.
  void row(int v, int width, float* cd_per_m2) const;

 private:
  struct Headlamps;
  void add_headlamps(const Scenario& scenario, const Headlamps& source);
  void add_street_lamps(const Scenario& scenario, double time_s);
  /// Luminance by one street lamp, mean of its flicker, on the whole grid.
  std::vector<float> street_light(const Scenario& scenario, std::size_t lamp, double time_s) const;

  GroundMap map_;
  Eigen::Vector3d camera_m_;
  std::vector<float> light_;
  std::vector<std::vector<float>> still_street_light_;  ///< by lamp, for sensors that do not move
  bool dark_ = true;
};

/// Illuminance of a ground point by one lamp pair that heads along `forward`; lx.
double ground_illuminance_lx(const LampBeam& beam, int lamps, const Eigen::Vector3d& lamp_m,
                             double heading_rad, double pitch_rad, const Eigen::Vector2d& point_m);

/// Illuminance of a ground point by a street lamp at `lamp_m`, above the ground; lx.
double street_illuminance_lx(double intensity_cd, const Eigen::Vector3d& lamp_m,
                             const Eigen::Vector2d& point_m);

}  // namespace vildar
