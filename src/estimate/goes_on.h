#pragma once

#include "estimate/vehicle.h"

namespace vildar {

/// Whether `later` is seen from one frame to the next, or within 0.15 s, just where the lamps of
/// `earlier` would be by then: within 4 px and three tenths of the step that they take. Its track
/// was cut there. Of two lamps and one that is seen it is enough that this is one of them.
bool goes_on_as(const VehicleEstimate& earlier, const VehicleEstimate& later);

}  // namespace vildar
