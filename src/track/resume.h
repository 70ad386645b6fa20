#pragma once

#include "track/vehicle.h"

namespace vildar {

/// Whether a pair that has just been found stands where a vehicle that was lost from view, or taken
/// apart, would have got to: at its speed along the road, and as far across it. For a sensor that
/// stands.
bool goes_on(const Vehicle& lost, const Vehicle& found, const RoadView& view);

/// The found vehicle takes over what was seen of the lost one.
void resume(const Vehicle& lost, Vehicle& found);

}  // namespace vildar
