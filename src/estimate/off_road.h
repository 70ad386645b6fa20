#pragma once

#include <span>
#include <string>

#include "estimate/trajectory.h"
#include "types/site.h"
#include "types/vehicle_track.h"

namespace vildar {

/// A light that never had a partner and drives in no lane is likelier lit paint or a lamp's image
/// on the road than a vehicle: few of those do. So is a pair the marker lamps on a lorry's roof,
/// where those would be in a lane: nearer than lamps at lamp height would be, and slower; beside
/// the road's outermost lane, in one of the other direction though its own has several, and where
/// more of them stand in their row, wherever no lane is. What a part of a track makes of a pair
/// beside the lanes is not believed, nor, before a camera that stands, a pair farther from the
/// lanes of its direction than one lane more.
bool in_no_lane(const VehicleTrack& track, const Site& site,
                std::span<const Trajectory> trajectories);

/// Words for who reads that a vehicle drives at y = `lateral_m` in no lane.
std::string beside_the_lanes(double lateral_m);

}  // namespace vildar
