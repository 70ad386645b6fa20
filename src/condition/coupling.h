#pragma once

#include "types/power.h"

namespace vildar {

/// Whether the amplifier, or a sound card, blocks constant light: after each vehicle the level is
/// below what it was before, by 2 % of the vehicle's light (5 % of an only one's) and 20 sigmas of
/// a mean of 20 ms at least, and creeps back ever more slowly, where light of the next vehicle
/// rises ever faster. Told by most of the vehicles in the trace, whose noise is set. What it was
/// before is the dark only where it holds for a second, and nowhere else a lower level does. Asked
/// before samples below zero are left out, which the swing may be.
bool blocks_constant_light(const PowerTrace& trace);

}  // namespace vildar
