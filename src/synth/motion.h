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

/// In the road frame of t = 0; `time_s` is clip time, before 0 included. A vehicle that slows down
/// to a stop stays there until it is told to speed up.
VehicleState state_at(const VehicleScene& vehicle, const RoadSite& road, double time_s);

/// The same for all vehicles in the frame that moves with the sensors (equal for fixed ones);
/// speeds stay over the ground.
std::vector<VehicleState> states_at(const Scenario& scenario, double time_s);
VehicleState seen_state_at(const Scenario& scenario, std::size_t vehicle, double time_s);

/// Index of the lane that the vehicle is in, the new one from the middle of a lane change on.
int lane_at(const VehicleScene& vehicle, double time_s);

/// How far the nose is up.
double pitch_rad_at(const VehicleScene& vehicle, double time_s);

/// One lamp, or two from the vehicle's right to its left.
std::vector<Eigen::Vector3d> lamp_positions_m(const VehicleScene& vehicle,
                                              const VehicleState& state);

/// Whether the lamps send their light toward the point: head lamps forward, tail lamps back.
bool lamps_face(const VehicleScene& vehicle, const VehicleState& state,
                const Eigen::Vector3d& point_m);

/// Whether a point is inside the body of `vehicle`.
bool body_holds(const VehicleScene& vehicle, const VehicleState& state,
                const Eigen::Vector3d& point_m);

/// Whether the body of `vehicle` stands between the two points. Bodies are boxes of the usual size
/// of their kind, with the lamps in the front (head) or the rear face (tail).
bool body_hides(const VehicleScene& vehicle, const VehicleState& state,
                const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m);

}  // namespace vildar
