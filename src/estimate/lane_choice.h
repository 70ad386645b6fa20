#pragma once

#include <cstddef>
#include <vector>

#include "types/site.h"

namespace vildar {

/// Lateral offset of a lane's vehicles: the site's prior, or where it calls the offset known, a
/// twelfth of the width, about 0.3 m.
Uncertain lane_prior_m(const LaneSite& lane);

/// Edges of the road and of the verges on both sides, as lateral offsets. Needs a lane.
struct RoadEdges {
  double low_m = 0.0, high_m = 0.0;
};
RoadEdges road_edges(const RoadSite& road);

/// Lanes of `direction` that a vehicle at this lateral offset (mean and std, lane not assumed) may
/// be in: those within five sigmas.
std::vector<const LaneSite*> lanes_near(const RoadSite& road, Direction direction,
                                        Uncertain lateral_m);

/// How many lanes are oncoming.
std::size_t lanes_towards(const RoadSite& road);

/// Whether vehicles drive away as well, with tail lamps whose light moves the other way.
bool two_way(const RoadSite& road);

/// One who goes across by less keeps to a lane.
inline constexpr double kAcrossALane_m = 1.0;

/// Share of vehicles that drive in no lane: they change lanes, overtake, park.
inline constexpr double kOffLaneShare = 0.02;

}  // namespace vildar
