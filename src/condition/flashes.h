#pragma once

#include <cstdint>

#include "types/power.h"

namespace vildar {

/// Takes out flashes, of lightning or a camera: light that doubles or more within two samples or a
/// millisecond, by 12 sigma of the noise (`noise_sigma_w`, which must be set), fades from the
/// first, and within 0.5 s is back to what it was. A lamp that is switched on, or comes out from
/// behind something, stays; what flashes more than five times in 3 s (a beacon, lamps that pulse)
/// stays as it is. Gives the number of samples taken out.
std::int64_t drop_flashes(PowerTrace& trace);

}  // namespace vildar
