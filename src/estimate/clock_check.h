#pragma once

#include <optional>
#include <span>
#include <string>

#include "estimate/trajectory.h"
#include "estimate/vehicle.h"

namespace vildar {

/// What is wrong with the photodiodes' clock beside the clip's, for a person to read; nothing where
/// it may be right. The delay between two photodiodes is the same by any clock, but told with the
/// wrong one it is the speed of another time. Wrong is a clock
/// - at which the light does not fit the bearings, but does with another, up to 3 s off;
/// - by which the light goes on rising when the bearings have the vehicle past: headlamps do not
///   shine back.
std::optional<std::string> clock_fault(const Trajectory& camera_only, const Site& site,
                                       std::span<const VehiclePower> power);

}  // namespace vildar
