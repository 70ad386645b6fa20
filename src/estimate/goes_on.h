#pragma once

#include "estimate/vehicle.h"

namespace vildar {

/// Whether `later` is seen from one frame to the next, or within 0.15 s, just where the lamps of
/// `earlier` would be by then: within 4 px and three tenths of the step that they take. Its track
/// was cut there. Of two lamps and one that is seen it is enough that this is one of them.
bool goes_on_as(const VehicleEstimate& earlier, const VehicleEstimate& later);

/// Whether `later` comes into view, within 1.5 s, where `earlier`, hidden since, would have got to:
/// both are likeliest the same thing in the same lane and, as that, in one place to 3 m, nearer
/// than vehicles follow, which is known to 5 m. The scale of all lengths, wrong alike for both,
/// does not count. False where either has no speed from the camera.
bool comes_out_again(const VehicleEstimate& earlier, const VehicleEstimate& later);

}  // namespace vildar
