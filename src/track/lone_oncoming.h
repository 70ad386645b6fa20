#pragma once

#include <vector>

#include "track/lamp.h"
#include "track/road_view.h"

namespace vildar {

/// Before a camera that drives along a straight road: whether a light cannot stand, for it would
/// stand on the carriageway, and moves through the picture as a headlamp would in an oncoming lane.
/// Elevation tells little from low down; how a light swells from the vanishing point tells where it
/// would stand, the camera's own speed being known. A
/// lit island or a parked car between the outer edges of the lanes is not told from one.
bool comes_in_a_lane(const std::vector<LampRecord>& records, const RoadView& view);

/// Before a camera that drives along a straight road: whether a light cannot stand, for it would
/// stand on the carriageway or below the road, as one reads that gets away from the camera.
bool cannot_stand(const std::vector<LampRecord>& records, const RoadView& view);

/// Before a camera that stands beside a straight road, level with the lamps: whether a light moves
/// through the picture as a lamp in a lane of its direction would, at a speed that changes by some
/// 0.5 m/s², for its elevation tells little. The camera may look aside by two sigmas of its yaw.
/// The light must come nearer, or go off, by a third.
bool passes_in_a_lane(const std::vector<LampRecord>& records, LampKind kind, const RoadView& view);

}  // namespace vildar
