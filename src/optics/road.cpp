#include "optics/road.h"

#include <algorithm>

namespace vildar {

Uncertain bend_begins_m(const RoadSite& road) {
  constexpr double kPlainShare = 0.1, kPlain_m = 1.0;
  Uncertain straight_m = road.straight_m;
  if (straight_m.std == 0.0 && straight_m.mean > 0.0)
    straight_m.std = std::max(kPlain_m, kPlainShare * straight_m.mean);
  return straight_m;
}

RoadPosition road_position(const RoadSite& road, double x_m, double y_m) {
  const double bend = bend_of(road);
  if (bend == 0.0 || !road.radius_m || x_m <= road.straight_m.mean) return {x_m, y_m};
  const double radius_m = road.radius_m->mean;
  // Seen from the arc's centre (straight_m, bend * radius_m).
  const double across_m = x_m - road.straight_m.mean;
  const double toward_m = radius_m - bend * y_m;
  const double lane_radius_m = std::hypot(across_m, toward_m);
  const double beta_rad = std::atan2(across_m, toward_m);
  return {road.straight_m.mean + lane_radius_m * beta_rad, bend * (radius_m - lane_radius_m)};
}

}  // namespace vildar
