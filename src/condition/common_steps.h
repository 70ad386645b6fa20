#pragma once

#include <vector>

#include "core/quantity.h"
#include "types/power.h"

namespace vildar {

/// Takes out light that is switched on and off, or off and on, before photodiodes that stand
/// `along` the road from one another, one place per trace: a sign, a beacon, a street lamp. It
/// jumps within 1 or 4 ms (or a sample) at once in two of them that are a metre apart or more, up
/// in one and down in the other where lamps shine in turn that are each nearer to one of them,
/// where what a vehicle's body does to its light comes later to one; and it jumps back in at most a
/// minute: by as much within a twentieth and the noise, what goes out for a while within a third.
/// Jumps of 8 sigmas of their noise (`noise_sigma_w`, which must be set) are seen; where there are
/// more than ten in a second, as of lamps that pulse, all stay, as they do in traces of less than
/// 250 Hz. Samples in the block of a jump are left out and counted as "switching". Writes to each
/// trace's `switched_w` the largest jump taken out of it.
void remove_common_steps(std::vector<PowerTrace>& traces, const std::vector<Metres>& along);

}  // namespace vildar
