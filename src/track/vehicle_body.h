#pragma once

#include "track/vehicle.h"

namespace vildar {

/// Whether a light stands where a part of the vehicle's body would: from below its lamps to a roof,
/// up to 4.5 m behind them. The vehicle needs both its lamps.
bool stands_within_body(const Lamp& light, const Vehicle& vehicle, const RoadView& view);

/// What is on a body keeps its place there; a lamp of another vehicle that is seen over its roof,
/// or beside it, wanders over it as the two come nearer, however alike they move. Told by the
/// frames in which the light and both lamps were seen; false where these are few.
bool changes_place_on_body(const Lamp& light, const Vehicle& vehicle, const RoadView& view);

}  // namespace vildar
