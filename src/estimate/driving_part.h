#pragma once

#include <optional>

#include "optics/camera.h"
#include "types/site.h"
#include "types/vehicle_track.h"

namespace vildar {

/// The part of a track in which the vehicle drives farthest without standing, where it stands for
/// 1.2 s or more before a camera that stands and is a metre or more over its lamps: it moves by
/// 0.8 m at most, along the road and across, as its elevation tells. Nothing where it is never seen
/// to stand, or where no such part is 5 m and a dozen frames long.
std::optional<VehicleTrack> driving_part(const VehicleTrack& track, const Camera& camera,
                                         const Site& site);

}  // namespace vildar
