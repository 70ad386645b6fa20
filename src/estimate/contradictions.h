#pragma once

#include <span>
#include <string>

#include "estimate/trajectory.h"
#include "types/result.h"

namespace vildar {

/// Compares the photodiode's own speeds with the camera's at their times. One beyond both intervals
/// is a warning; and where light and bearings could not be fitted together either, and the
/// photodiode's sigma is not much the larger, neither sensor can be trusted over the other and the
/// speed is withheld as sensors_contradict. Where they could, a row that rests on the power law is
/// withheld as outside_model. `result` holds a speed from `trajectories`.
void check_sensors(std::span<const Trajectory> trajectories, VehicleResult& result);

/// Where the delays of two or more vehicles, and of most that have both, deny the speeds by the
/// power law, no speed that rests on that law alone stands: it is withheld as outside_model.
void check_law(std::span<VehicleResult> vehicles);

/// What to check where the light of photodiodes says a speed that is too_fast().
std::string warning_of_too_fast(Method method, const SpeedEstimate& speed);

/// Whether two speeds of one time lie apart beyond their intervals.
bool apart(const SpeedEstimate& one, const SpeedEstimate& other);

}  // namespace vildar
