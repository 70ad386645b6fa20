#include "synth/motion.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "optics/road.h"

namespace vildar {
namespace {

struct BodySize {
  double length_m, width_m, height_m;
};

BodySize body_size(VehicleKind kind) {
  switch (kind) {
    case VehicleKind::car: return {4.4, 1.8, 1.5};
    case VehicleKind::lorry: return {12.0, 2.5, 3.8};
    case VehicleKind::motorcycle: return {2.1, 0.8, 1.5};
  }
  return {};
}

Eigen::Vector2d left_of(const Eigen::Vector2d& forward) { return {-forward.y(), forward.x()}; }

}  // namespace

VehicleState state_at(const VehicleScene& vehicle, const RoadSite& road, double time_s) {
  const LaneSite& lane = road.lanes[static_cast<std::size_t>(vehicle.lane)];
  const double way = lane.direction == Direction::oncoming ? -1.0 : 1.0;
  VehicleState state;
  double moving_s = time_s;
  state.acceleration_mps2 = vehicle.acceleration_mps2;
  if (vehicle.acceleration_mps2 != 0.0) {
    const double stop_s = -vehicle.speed_mps / vehicle.acceleration_mps2;
    const bool stands = vehicle.acceleration_mps2 < 0.0 ? time_s >= stop_s : time_s <= stop_s;
    if (stands) {
      moving_s = stop_s;
      state.acceleration_mps2 = 0.0;
    }
  }
  const double gone_m =
      vehicle.speed_mps * moving_s + 0.5 * vehicle.acceleration_mps2 * moving_s * moving_s;
  state.speed_mps = std::max(0.0, vehicle.speed_mps + vehicle.acceleration_mps2 * moving_s);
  const double radius_m = road.radius_m ? road.radius_m->mean : 0.0;
  const PathPoint<double> point = path_point(vehicle.along_at_zero_m + way * gone_m,
                                             lane.lateral_m.mean + vehicle.lateral_offset_m,
                                             bend_of(road), road.straight_m, radius_m);
  state.place_m = {point.x_m, point.y_m};
  state.forward = way * Eigen::Vector2d(std::cos(point.heading_rad), std::sin(point.heading_rad));
  return state;
}

std::vector<Eigen::Vector3d> lamp_positions_m(const VehicleScene& vehicle,
                                              const VehicleState& state) {
  const auto lifted = [&](const Eigen::Vector2d& ground_m) {
    return Eigen::Vector3d(ground_m.x(), ground_m.y(), vehicle.lamp_height_m);
  };
  if (vehicle.lamp_separation_m == 0.0) return {lifted(state.place_m)};
  const Eigen::Vector2d half_m = 0.5 * vehicle.lamp_separation_m * left_of(state.forward);
  return {lifted(state.place_m - half_m), lifted(state.place_m + half_m)};
}

bool lamps_face(const VehicleScene& vehicle, const VehicleState& state,
                const Eigen::Vector3d& point_m) {
  const double ahead_m = (point_m.head<2>() - state.place_m).dot(state.forward);
  return vehicle.lamps == VehicleLamps::head ? ahead_m > 0.0 : ahead_m < 0.0;
}

bool body_hides(const VehicleScene& vehicle, const VehicleState& state,
                const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m) {
  const BodySize size = body_size(vehicle.kind);
  const bool front = vehicle.lamps == VehicleLamps::head;
  const Eigen::Vector2d left = left_of(state.forward);
  const auto in_body = [&](const Eigen::Vector3d& point_m) {
    const Eigen::Vector2d offset_m = point_m.head<2>() - state.place_m;
    return Eigen::Vector3d(offset_m.dot(state.forward), offset_m.dot(left), point_m.z());
  };
  const Eigen::Vector3d low(front ? -size.length_m : 0.0, -0.5 * size.width_m, 0.0);
  const Eigen::Vector3d high(front ? 0.0 : size.length_m, 0.5 * size.width_m, size.height_m);
  const Eigen::Vector3d start = in_body(from_m);
  const Eigen::Vector3d step = in_body(to_m) - start;
  // Slab by slab: the stretch of the line that lies inside the box.
  double enter = 0.0, leave = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    if (step[axis] == 0.0) {
      if (start[axis] <= low[axis] || start[axis] >= high[axis]) return false;
      continue;
    }
    double first = (low[axis] - start[axis]) / step[axis];
    double second = (high[axis] - start[axis]) / step[axis];
    if (first > second) std::swap(first, second);
    enter = std::max(enter, first);
    leave = std::min(leave, second);
  }
  return enter < leave;
}

}  // namespace vildar
