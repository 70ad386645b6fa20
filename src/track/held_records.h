#pragma once

#include "track/pairing.h"

namespace vildar {

/// Drops the oldest records of lights that may stay for hours: of those without a partner, and of
/// pairs that have not moved since they were found (parked cars, lit windows), of which nothing is
/// reported while they stand. What drives off after all has
/// its last minute before that.
void drop_old_records(const Lamps& lamps, const Vehicles& vehicles);

}  // namespace vildar
