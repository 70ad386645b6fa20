#pragma once

#include <span>

#include "track/lamp.h"

namespace vildar {

/// Share of the looks at which a light stood more than 3 px from its course, that of most of its
/// looks within a stretch of 2 to 4 s: along the road at constant acceleration, across it at
/// constant speed. 0 from a camera that moves, whose own turning moves lamps as well, and of a few
/// looks.
double off_course_share(std::span<const LampRecord> records, const RoadView& view);

}  // namespace vildar
