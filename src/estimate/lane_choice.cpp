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

LaneChoice choose_lane(const RoadSite& road, Direction direction, Uncertain lateral_m) {
  // Three sigmas to belong; twenty to one against the next lane.
  constexpr double kFarthest2 = 9.0;
  constexpr double kLead2 = 6.0;
  constexpr double kVerge_m = 3.0;
  LaneChoice choice;
  if (road.lanes.empty()) return choice;
  double best2 = std::numeric_limits<double>::infinity(), next2 = best2;
  double low_m = best2, high_m = -best2;
  for (const LaneSite& lane : road.lanes) {
    low_m = std::min(low_m, lane.lateral_m.mean - 0.5 * lane.width_m);
    high_m = std::max(high_m, lane.lateral_m.mean + 0.5 * lane.width_m);
    if (lane.direction != direction) continue;
    const Uncertain prior_m = lane_prior_m(lane);
    const double apart_m = lateral_m.mean - prior_m.mean;
    const double apart2 =
        apart_m * apart_m / (lateral_m.std * lateral_m.std + prior_m.std * prior_m.std);
    if (apart2 < best2) {
      next2 = best2;
      best2 = apart2;
      choice.lane = &lane;
    } else {
      next2 = std::min(next2, apart2);
    }
  }
  if (!(best2 <= kFarthest2 && next2 - best2 >= kLead2)) choice.lane = nullptr;
  const double margin_m = kVerge_m + 3.0 * lateral_m.std;
  choice.off_road = lateral_m.mean < low_m - margin_m || lateral_m.mean > high_m + margin_m;
  return choice;
}

}  // namespace vildar
