#pragma once

#include "track/pairing.h"

namespace vildar {

/// So many records of a light without a partner, or of a pair that has not moved, are held at
/// least, and twice as many at most.
inline constexpr std::size_t kHeldAlone = 2000;

/// Drops the oldest records of lights that may stay for hours: of those without a partner, and of
/// pairs that have not moved since they were found (parked cars, lit windows), of which nothing is
/// reported while they stand. What drives off after all has its last 2000 frames before that.
void drop_old_records(const Lamps& lamps, const Vehicles& vehicles);

}  // namespace vildar
