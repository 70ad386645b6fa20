#pragma once

#include "estimate/vehicle.h"

namespace vildar {

/// Whether two measured pairs are those of a car and of the trailer that it draws: in one line,
/// nearer to one another than any vehicle follows (3.5 m and a quarter of a second) while their
/// distance from the camera changes by a third or more, and the distance of either is that of the
/// other but for a length that stays and what their scales, as far as known, may differ by.
bool one_draws_the_other(const VehicleEstimate& one, const VehicleEstimate& other);

}  // namespace vildar
