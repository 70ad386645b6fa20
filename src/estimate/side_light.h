#pragma once

#include "estimate/vehicle.h"

namespace vildar {

/// Whether a lone `light` is a marker on the side of `carrier`, which shows its pair: its bearings
/// are those of one place on a body that moves as the carrier does, behind the pair (of tail lamps:
/// ahead of it) and as far beside the middle as a body's side is for a pair that stands so far
/// apart. Further from the pair than a car is long, that stands as far apart as a lorry's. What
/// follows a vehicle keeps to the middle of its lane, or farther aside. False where fewer than ten
/// frames show the light within 1.5 s of the carrier, and on bends, where bodies turn.
bool is_side_marker(const VehicleEstimate& light, const VehicleEstimate& carrier);

}  // namespace vildar
