#include "estimate/lane_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vildar {

Uncertain lane_prior_m(const LaneSite& lane) {
  constexpr double kWidthsPerSigma = 12.0;
  return {lane.lateral_m.mean,
          lane.lateral_m.std > 0.0 ? lane.lateral_m.std : lane.width_m / kWidthsPerSigma};
}

RoadEdges road_edges(const RoadSite& road) {
  constexpr double kVerge_m = 3.0;
  double low_m = std::numeric_limits<double>::infinity(), high_m = -low_m;
  for (const LaneSite& lane : road.lanes) {
    low_m = std::min(low_m, lane.lateral_m.mean - 0.5 * lane.width_m);
    high_m = std::max(high_m, lane.lateral_m.mean + 0.5 * lane.width_m);
  }
  return {low_m - kVerge_m, high_m + kVerge_m};
}

std::vector<const LaneSite*> lanes_near(const RoadSite& road, Direction direction,
                                        Uncertain lateral_m) {
  constexpr double kFarthest = 5.0;
  std::vector<const LaneSite*> near;
  for (const LaneSite& lane : road.lanes) {
    const Uncertain prior_m = lane_prior_m(lane);
    if (lane.direction == direction && std::abs(lateral_m.mean - prior_m.mean) <=
                                           kFarthest * std::hypot(lateral_m.std, prior_m.std))
      near.push_back(&lane);
  }
  return near;
}

std::size_t lanes_towards(const RoadSite& road) {
  return static_cast<std::size_t>(
      std::ranges::count(road.lanes, Direction::oncoming, &LaneSite::direction));
}

bool two_way(const RoadSite& road) {
  return std::ranges::count(road.lanes, Direction::receding, &LaneSite::direction) > 0;
}

}  // namespace vildar
