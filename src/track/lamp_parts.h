#pragma once

#include "track/road_view.h"
#include "types/blob.h"

namespace vildar {

/// Tail lamps of LEDs (rings, strips, matrices) are several lights where a picture resolves them,
/// as are the two headlamps of a motorcycle. Such parts of one lamp become one blob: red lights, or
/// white ones alike within a factor of two, each within 0.25 m beside another or, where
/// nothing clips, within 0.16 m above or below it, all within 0.42 m, at the greatest depth that
/// the elevation leaves likely, so that before low cameras far pairs stay two lamps. Its light is
/// the sum and its centre that of the parts' light. Identifiers are counted anew.
void join_lamp_parts(BlobFrame& frame, const RoadView& view);

}  // namespace vildar
