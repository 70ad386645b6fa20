#pragma once

#include "track/vehicle.h"

namespace vildar {

/// Whether a light without a partner was one of the two lamps of `vehicle` for most of the time
/// that tells, which is most of the time it was seen: it stood where the vehicle's pairs before and
/// after, or from shortly after on, say that this lamp was, or made a pair with the one lamp that
/// was seen of the vehicle.
bool was_lamp_of(const Lamp& light, const Vehicle& vehicle, const RoadView& view);

}  // namespace vildar
