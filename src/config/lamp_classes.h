#pragma once

#include "types/site.h"

namespace vildar {

/// Fills height_m and separation_m with mean and standard deviation of the classes taken together,
/// by their shares: what a reader that knows no classes may go by. Needs at least one class.
void pool_classes(LampsSite& lamps);

}  // namespace vildar
