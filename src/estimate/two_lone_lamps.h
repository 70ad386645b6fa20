#pragma once

#include <optional>
#include <utility>

#include "types/result.h"
#include "types/site.h"
#include "types/vehicle_track.h"

namespace vildar {

/// The lamps of a pair, each as the track of a vehicle of one lamp, left and right, both with the
/// pair's id.
std::pair<VehicleTrack, VehicleTrack> lamps_alone(const VehicleTrack& pair);

/// The same of a pair that no vehicle on this road explains (`found`: bad_fit, not_on_road, or
/// ambiguous_identity by its bearings), where the lamps are two vehicles', one behind the other:
/// each alone has a speed in a lane of its direction, one stays ahead of the other by more than a
/// vehicle's length, and they would not reach the camera at once, as lamps on one body and images
/// do. Nothing before a camera that drives, which is too little sure of where lone lamps are.
/// Throws std::invalid_argument where the site has no camera.
std::optional<std::pair<VehicleTrack, VehicleTrack>> two_lone_lamps(const VehicleTrack& pair,
                                                                    const VehicleResult& found,
                                                                    const Site& site);

}  // namespace vildar
