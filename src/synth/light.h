#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "synth/motion.h"

namespace vildar {

/// Red and blue of a light relative to a white of the same luminance (BT.709 primaries).
struct LightColour {
  double red = 1.0;
  double blue = 1.0;
};

/// A round lamp as a sensor sees it.
struct Emitter {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  double radius_m = 0.0;
  double intensity_cd = 0.0;
  LightColour colour;
  std::optional<std::size_t> vehicle;  ///< index into Scenario::vehicles; street lamps have none
  std::size_t lamp = 0;                ///< index into lamp_positions_m()
};

/// All lamps whose light reaches `sensor_m` at `time_s`: they face it and no body stands between.
/// On a wet road their mirror images too, below the road, drawn out by the slopes of the water
/// film.
std::vector<Emitter> emitters_toward(const Scenario& scenario, const Eigen::Vector3d& sensor_m,
                                     double time_s);

/// Whether the body of another vehicle hides a point of vehicle `index` from the sensor.
bool hidden_by_others(const Scenario& scenario, std::size_t index, const Eigen::Vector3d& point_m,
                      const Eigen::Vector3d& sensor_m, double time_s);

/// Share of unpolarised light that a water surface (n = 1.33) mirrors at an angle of `grazing_rad`
/// above it (0 along the surface), Fresnel.
double water_reflectance(double grazing_rad);

}  // namespace vildar
