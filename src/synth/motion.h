#pragma once

#include <vector>

#include <Eigen/Core>

#include "synth/scenario.h"

namespace vildar {

/// Where a vehicle is at one time, road frame.
struct VehicleState {
  Eigen::Vector2d place_m = Eigen::Vector2d::Zero();   ///< the middle of its lamps, on the ground
  Eigen::Vector2d forward = Eigen::Vector2d::UnitX();  ///< unit vector of its way
  double speed_mps = 0.0;
  double acceleration_mps2 = 0.0;
};

/// `time_s` is clip time, before 0 included. A vehicle that slows down to a stop stays there.
VehicleState state_at(const VehicleScene& vehicle, const RoadSite& road, double time_s);

/// One lamp, or two from the vehicle's right to its left.
std::vector<Eigen::Vector3d> lamp_positions_m(const VehicleScene& vehicle,
                                              const VehicleState& state);

/// Whether the lamps send their light toward the point: head lamps forward, tail lamps back.
bool lamps_face(const VehicleScene& vehicle, const VehicleState& state,
                const Eigen::Vector3d& point_m);

/// Whether the body of `vehicle` stands between the two points. Bodies are boxes of the usual size
/// of their kind, with the lamps in the front (head) or the rear face (tail).
bool body_hides(const VehicleScene& vehicle, const VehicleState& state,
                const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m);

}  // namespace vildar
