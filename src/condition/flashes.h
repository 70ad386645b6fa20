#pragma once

#include <cstdint>

#include "types/power.h"

namespace vildar {

/// Takes out flashes, of lightning or a camera: light that jumps by 6 sigmas of the noise
/// (`noise_sigma_w`, which must be set) from a sample to the next, doubles or more, and by 12
/// sigmas, within two samples or a millisecond, fades from the first, and within 0.5 s is back to
/// what it was. Twice the time of that goes. A lamp that is switched on, or comes out from behind
/// something, stays, and so does what comes after a gap; what flashes, or jumps as high, more than
/// five times within 3 s (a beacon, lamps that pulse) stays as it is. Gives the number of samples
/// taken out.
std::int64_t drop_flashes(PowerTrace& trace);

}  // namespace vildar
