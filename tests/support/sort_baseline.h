#pragma once

#include <vector>

#include "evaluate/folders.h"
#include "track/road_view.h"
#include "types/blob.h"

namespace vildar {

/// What a general tracker makes of the same detections: in each frame blobs are joined into pairs
/// that stand on the road as one vehicle's lamps would, the best first, what is left stands alone,
/// and each becomes a square box 1.4 lamp separations wide; the boxes are followed by SORT (Bewley
/// et al. 2016: constant-velocity Kalman filter on centre, area and aspect, assignment by overlap)
/// with the settings of its authors but for `max_age`, frames without a detection.
std::vector<RunVehicle> sort_baseline(const std::vector<BlobFrame>& frames, const RoadView& view,
                                      int max_age);

}  // namespace vildar
