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
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< frame that moves with the sensors
  double radius_m = 0.0;
  double intensity_cd = 0.0;  ///< toward the sensor, mean of its waveform, dimmed by the air
  LightColour colour;
  Waveform waveform;
  /// Standard deviation of its drawing-out upright, by water on the road.
  double streak_rad = 0.0;
  std::optional<std::size_t> vehicle;  ///< index into Scenario::vehicles; street lamps have none
  std::size_t lamp = 0;                ///< index into lamp_positions_m(), or of the street lamp
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();  ///< of a mirror image from its lamp
};

/// All lamps whose light reaches `sensor_m` at `time_s`: they face it and no body stands between.
/// On a wet road their mirror images too, below the road, drawn out by the slopes of the water
/// film.
std::vector<Emitter> emitters_toward(const Scenario& scenario, const Eigen::Vector3d& sensor_m,
                                     double time_s);

/// Where that emitter is at another time, were it still to be seen.
Eigen::Vector3d emitter_position_m(const Scenario& scenario, const Emitter& emitter, double time_s);

/// Intensity of one lamp of a vehicle toward a point it faces; mean of the waveform, clear air.
double lamp_intensity_cd(const VehicleScene& vehicle, const VehicleState& state,
                         const Eigen::Vector3d& lamp_m, const Eigen::Vector3d& toward_m,
                         double time_s);

/// Whether the body of another vehicle hides a point of vehicle `index` from the sensor.
bool hidden_by_others(const Scenario& scenario, const std::vector<VehicleState>& states,
                      std::size_t index, const Eigen::Vector3d& point_m,
                      const Eigen::Vector3d& sensor_m);

}  // namespace vildar
