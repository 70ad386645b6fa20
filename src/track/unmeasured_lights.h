#pragma once

#include "track/road_view.h"
#include "track/tracker.h"
#include "track/vehicle.h"

namespace vildar {

/// Counts a light without a partner that is gone, where it is no vehicle's, by what may be wrong.
void count_unmeasured(const Lamp& light, Verdict verdict, const RoadView& view,
                      TrackCounts& counts);

}  // namespace vildar
