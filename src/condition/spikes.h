#pragma once

#include <cstdint>

#include "types/power.h"

namespace vildar {

/// Takes out single samples, and pairs of them, that stand out of those about them as no light of
/// a vehicle does: by 12 sigma of the noise (`noise_sigma_w`, which must be set), by more than a
/// third of the light there, and by more than twice what light changes by next to them. They come
/// from switched loads and long cables. Lamps that pulse, whose samples stand out all the time
/// (more than one in twenty within a quarter of a second), stay as they are. Gives the number taken
/// out.
std::int64_t drop_spikes(PowerTrace& trace);

}  // namespace vildar
