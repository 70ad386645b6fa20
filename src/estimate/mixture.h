#pragma once

#include <span>
#include <string>

#include "estimate/trajectory.h"

namespace vildar {

// What is known of a vehicle that may be one of several things. All functions take the trajectories
// of fit_trajectories(), with their weights, the likeliest first.

/// Means, and standard deviations that hold the spread between the trajectories.
MotionState mixed_state(std::span<const Trajectory> trajectories, double time_s);

/// Speed over the ground: mean and standard deviation of the mixture, and the interval that leaves
/// 2.5 % of it on either side.
SpeedEstimate mixed_speed(std::span<const Trajectory> trajectories, double time_s);

/// Lane that has at least 95 % of the probability; empty where none has.
std::string sure_lane(std::span<const Trajectory> trajectories);

/// What could not be told apart, the likeliest first, and what each would mean at that time; empty
/// where one thing in one lane has at least 95 % of the probability.
std::string doubt_text(std::span<const Trajectory> trajectories, double time_s);

}  // namespace vildar
