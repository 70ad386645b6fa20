#pragma once

#include <string>

#include "types/site.h"

namespace vildar {

/// Lateral offset of a lane's vehicles: the site's prior, or where it calls the offset known, a
/// twelfth of the width, about 0.3 m.
Uncertain lane_prior_m(const LaneSite& lane);

struct LaneChoice {
  const LaneSite* lane = nullptr;  ///< null where none fits, or more than one does
  bool off_road = false;           ///< well beyond the edge of every lane of either direction
};

/// Lane of `direction` that a vehicle at this lateral offset (mean and std, lane not assumed) is
/// in.
LaneChoice choose_lane(const RoadSite& road, Direction direction, Uncertain lateral_m);

}  // namespace vildar
