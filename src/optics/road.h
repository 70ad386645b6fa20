#pragma once

#include <cmath>

#include "types/site.h"

namespace vildar {

/// Point of a lane's path in the road frame: (x, y), and the path's heading away from the sensor.
template <class T>
struct PathPoint {
  T x_m, y_m;
  T heading_rad;  ///< anticlockwise from +x
};

/// Where a path at lateral offset `lateral_m` stands `along_m` metres of its own length from x = 0.
/// Straight roads: (along, lateral). Curved roads: straight for `straight_m`, then an arc tangent
/// to it whose radius for the line y = 0 is `radius_m`; lanes are concentric (SPEC 1, paper eqs.
/// 17-19). `bend` is +1 for a left turn, -1 for a right one, 0 for a straight road. T may be a
/// ceres::Jet. Needs radius_m - bend * lateral_m > 0.
template <class T, class Straight = double>
PathPoint<T> path_point(const T& along_m, const T& lateral_m, double bend,
                        const Straight& straight_m, const T& radius_m) {
  using std::cos;
  using std::sin;
  if (bend == 0.0 || !(along_m > T(straight_m))) return {along_m, lateral_m, T(0.0)};
  const T lane_radius_m = radius_m - bend * lateral_m;
  const T beta_rad = (along_m - straight_m) / lane_radius_m;
  return {straight_m + lane_radius_m * sin(beta_rad),
          lateral_m + bend * lane_radius_m * (1.0 - cos(beta_rad)), bend * beta_rad};
}

/// Where the bend begins, with what it is known to. Real roads pass into their bends over tens of
/// metres: a plain number is taken as known to 10 %, and to 1 m at best. 0 m, plain: the sensor
/// stands on the bend, and so does all it sees.
Uncertain bend_begins_m(const RoadSite& road);

/// +1 left, -1 right, 0 straight.
inline double bend_of(const RoadSite& road) {
  if (road.kind == RoadKind::straight) return 0.0;
  return road.turn == Turn::left ? 1.0 : -1.0;
}

/// Along-path length and lateral offset of a ground point (inverse of path_point).
struct RoadPosition {
  double along_m = 0.0;
  double lateral_m = 0.0;
};
RoadPosition road_position(const RoadSite& road, double x_m, double y_m);

}  // namespace vildar
