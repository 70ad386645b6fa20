#pragma once

#include <optional>

#include "types/power.h"

namespace vildar {

/// After how long the light between two times of the trace comes again, where it does so four times
/// in turn and more, evenly, 0.2 to 1.4 s apart and alike to 15 % (rms) beside the noise: lamps
/// that flash, turn or swing. Vehicles follow one another neither so closely nor so evenly.
std::optional<double> comes_again_after_s(const PowerTrace& trace, double from_s, double to_s);

}  // namespace vildar
