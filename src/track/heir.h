#pragma once

#include "track/vehicle.h"

namespace vildar {

/// How far from `older` a lamp came out of its blob, when it was first seen; nothing where it did
/// not. In pixels.
std::optional<double> came_out_of(const Lamp& younger, const Lamp& older);

/// Makes a lamp of `vehicle` what came out of the blob of the one that it was followed as, which
/// goes on as a light of its own. Until then that blob was of both. False, and nothing is done,
/// where the vehicle has not that other lamp, or has not seen it with `kept`, or where the new one
/// stands at another distance from `kept` or on its other side.
bool hand_over(Vehicle& vehicle, const Lamp& kept, Lamp& heir);

/// Where both lamps of `vehicle` are seen for the first time and one came out of the other's blob,
/// what was seen of that before was of both. Nothing is done elsewhere.
void mark_split_records(Vehicle& vehicle);

}  // namespace vildar
