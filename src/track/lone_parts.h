#pragma once

#include <vector>

#include "track/lamp.h"
#include "types/vehicle_track.h"

namespace vildar {

/// A frame of a vehicle.
struct SeenVehicle {
  VehicleSighting sighting;
  bool fits = true;  ///< where both were seen, as one vehicle's lamps
};

/// Leaves out the frames of a vehicle in which one light alone was seen, where that may not have
/// been its lamp: long before it was first seen as a pair or a while after it last was; as wide as
/// no lamp of it is, or before that pair of another brightness (merged with other lights, or one of
/// them); or more of them before the first pair than `least_pair_share` pairs can vouch for. A pair
/// more than a second from those in a row counts for none. In order of frames.
void drop_strange_parts(std::vector<SeenVehicle>& seen, double least_pair_share);

/// Of two lamps that step apart or together from one frame to the next one was paired with another
/// light before, or after: keeps what is longest, and what goes on as that did after, or before, a
/// few looks at something else (0.7 s). False where that is not most of it.
bool keep_longest_pair(std::vector<LampRecord>& left, std::vector<LampRecord>& right);

}  // namespace vildar
