#pragma once

#include <cstdint>

#include "types/power.h"

namespace vildar {

/// Takes out the samples that no light can give: below zero and far below the trace's own darkest
/// part, further than its noise (`noise_sigma_w`, which must be set) and four times the spread of
/// that part explain. Negative samples within noise stay, and so does the dark level of an
/// amplifier whose zero lies too low. Gives the number taken out.
std::int64_t drop_negative(PowerTrace& trace);

}  // namespace vildar
