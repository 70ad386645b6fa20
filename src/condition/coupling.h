#pragma once

#include "types/power.h"

namespace vildar {

/// Whether the amplifier, or a sound card, blocks constant light: after each vehicle the level is
/// below what it was before, by 2 % of the vehicle's light and 20 sigmas of a mean of 20 ms at
/// least, and creeps back ever more slowly, where light of the next vehicle rises ever faster. Told
/// by most of the vehicles in the trace, in which that of `noise_sigma_w` is set.
bool blocks_constant_light(const PowerTrace& trace);

}  // namespace vildar
