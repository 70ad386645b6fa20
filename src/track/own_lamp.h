#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "track/vehicle.h"

namespace vildar {

/// Whether a light without a partner was one of the two lamps of `vehicle` for most of the time
/// that tells, which is most of the time it was seen: it stood where the vehicle's pairs before and
/// after, or from shortly after on, say that this lamp was, or made a pair with the one lamp that
/// was seen of the vehicle.
bool was_lamp_of(const Lamp& light, const Vehicle& vehicle, const RoadView& view);

/// The last frame before the first pair of `vehicle` in which a light that is held for one of its
/// lamps was, as far as that tells, a lamp of one of `others` whose own first pair is earlier:
/// until then the light was not this vehicle's. Nothing where there is none.
std::optional<std::int64_t> last_frame_as_another(const Vehicle& vehicle,
                                                  const std::vector<const Vehicle*>& others,
                                                  const RoadView& view);

}  // namespace vildar
