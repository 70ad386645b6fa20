#pragma once

#include <span>

#include "estimate/trajectory.h"
#include "types/site.h"
#include "types/vehicle_track.h"

namespace vildar {

/// A light that never had a partner and drives in no lane is likelier lit paint or a lamp's image
/// on the road than a vehicle: few of those do. So is a pair the marker lamps on a lorry's roof,
/// where those would be in a lane: nearer than lamps at lamp height would be, and slower. And what
/// a part of a track makes of a pair far beside the lanes is not believed.
bool in_no_lane(const VehicleTrack& track, const Site& site,
                std::span<const Trajectory> trajectories);

}  // namespace vildar
