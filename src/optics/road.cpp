#include "optics/road.h"

namespace vildar {

RoadPosition road_position(const RoadSite& road, double x_m, double y_m) {
  const double bend = bend_of(road);
  if (bend == 0.0 || !road.radius_m || x_m <= road.straight_m) return {x_m, y_m};
  const double radius_m = road.radius_m->mean;
  // Seen from the arc's centre (straight_m, bend * radius_m).
  const double across_m = x_m - road.straight_m;
  const double toward_m = radius_m - bend * y_m;
  const double lane_radius_m = std::hypot(across_m, toward_m);
  const double beta_rad = std::atan2(across_m, toward_m);
  return {road.straight_m + lane_radius_m * beta_rad, bend * (radius_m - lane_radius_m)};
}

}  // namespace vildar
