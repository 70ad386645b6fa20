#include "synth/motion.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/quantity.h"
#include "optics/road.h"
#include "synth/ego.h"

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

struct Progress {
  double gone_m = 0.0;
  double speed_mps = 0.0;
  double acceleration_mps2 = 0.0;
};

// Uniform acceleration for `span_s`, which may be negative; speeds do not change sign.
Progress moved(const Progress& start, double span_s) {
  Progress end = start;
  double moving_s = span_s;
  if (start.acceleration_mps2 != 0.0) {
    const double stop_s = -start.speed_mps / start.acceleration_mps2;
    const bool stands = start.acceleration_mps2 < 0.0 ? span_s >= stop_s : span_s <= stop_s;
    if (stands) {
      moving_s = stop_s;
      end.acceleration_mps2 = 0.0;
    }
  }
  end.gone_m += start.speed_mps * moving_s + 0.5 * start.acceleration_mps2 * moving_s * moving_s;
  end.speed_mps = std::max(0.0, start.speed_mps + start.acceleration_mps2 * moving_s);
  return end;
}

Progress progress_at(const VehicleScene& vehicle, double time_s) {
  Progress progress{0.0, vehicle.speed_mps, vehicle.acceleration_mps2};
  double from_s = 0.0;
  for (const SpeedChange& change : vehicle.speed_changes) {
    if (time_s <= change.from_s) break;
    progress = moved(progress, change.from_s - from_s);
    progress.acceleration_mps2 = change.acceleration_mps2;
    from_s = change.from_s;
  }
  return moved(progress, time_s - from_s);
}

double shift_m_at(const VehicleScene& vehicle, double time_s) {
  double shift_m = 0.0;
  for (const LaneChange& change : vehicle.lane_changes) {
    const double x = std::clamp((time_s - change.from_s) / change.duration_s, 0.0, 1.0);
    shift_m += change.shift_m * x * x * x * (10.0 + x * (6.0 * x - 15.0));
  }
  return shift_m;
}

// Place as it is; way and speed along the lane, without the move sideways.
VehicleState undisturbed(const VehicleScene& vehicle, const RoadSite& road, double time_s) {
  const LaneSite& lane = road.lanes[static_cast<std::size_t>(vehicle.lane)];
  const double way = lane.direction == Direction::oncoming ? -1.0 : 1.0;
  const Progress progress = progress_at(vehicle, time_s);
  VehicleState state;
  state.speed_mps = progress.speed_mps;
  state.acceleration_mps2 = progress.acceleration_mps2;
  const double bend = bend_of(road);
  const double radius_m = road.radius_m ? road.radius_m->mean : 0.0;
  const double lateral_m = lane.lateral_m.mean + vehicle.lateral_offset_m;
  const double shift_m = shift_m_at(vehicle, time_s);
  double along_m = vehicle.along_at_zero_m + way * progress.gone_m;
  // The arc angle is what the lanes share.
  if (bend != 0.0 && shift_m != 0.0 && along_m > road.straight_m.mean)
    along_m = road.straight_m.mean + (along_m - road.straight_m.mean) *
                                         (radius_m - bend * (lateral_m + shift_m)) /
                                         (radius_m - bend * lateral_m);
  const PathPoint<double> point =
      path_point(along_m, lateral_m + shift_m, bend, road.straight_m.mean, radius_m);
  state.place_m = {point.x_m, point.y_m};
  state.forward = way * Eigen::Vector2d(std::cos(point.heading_rad), std::sin(point.heading_rad));
  return state;
}

}  // namespace

VehicleState state_at(const VehicleScene& vehicle, const RoadSite& road, double time_s) {
  VehicleState state = undisturbed(vehicle, road, time_s);
  if (vehicle.lane_changes.empty()) return state;
  // Differences over 2 ms: a quintic of a few seconds is a parabola on that scale.
  constexpr double kStep_s = 1e-3;
  const auto place_m = [&](double at_s) { return undisturbed(vehicle, road, at_s).place_m; };
  const auto velocity = [&](double at_s) -> Eigen::Vector2d {
    return (place_m(at_s + kStep_s) - place_m(at_s - kStep_s)) / (2.0 * kStep_s);
  };
  if (state.speed_mps == 0.0) return state;
  const Eigen::Vector2d now = velocity(time_s);
  state.forward = now.normalized();
  state.speed_mps = now.norm();
  state.acceleration_mps2 =
      (velocity(time_s + kStep_s).norm() - velocity(time_s - kStep_s).norm()) / (2.0 * kStep_s);
  return state;
}

VehicleState seen_state_at(const Scenario& scenario, std::size_t vehicle, double time_s) {
  VehicleState state = state_at(scenario.vehicles[vehicle], scenario.site.road, time_s);
  if (!scenario.site.ego) return state;
  const EgoPose ego = ego_pose(scenario.site, time_s);
  state.place_m = ego.seen_m(state.place_m);
  state.forward = ego.turned(state.forward);
  return state;
}

std::vector<VehicleState> states_at(const Scenario& scenario, double time_s) {
  std::vector<VehicleState> states;
  states.reserve(scenario.vehicles.size());
  const EgoPose ego = ego_pose(scenario.site, time_s);
  for (const VehicleScene& vehicle : scenario.vehicles) {
    VehicleState state = state_at(vehicle, scenario.site.road, time_s);
    state.place_m = ego.seen_m(state.place_m);
    state.forward = ego.turned(state.forward);
    states.push_back(state);
  }
  return states;
}

int lane_at(const VehicleScene& vehicle, double time_s) {
  int lane = vehicle.lane;
  for (const LaneChange& change : vehicle.lane_changes)
    if (time_s >= change.from_s + 0.5 * change.duration_s) lane = change.to_lane;
  return lane;
}

double pitch_rad_at(const VehicleScene& vehicle, double time_s) {
  const PitchScene& pitch = vehicle.pitch;
  return pitch.amplitude_rad * std::sin(2.0 * kPi * pitch.frequency_hz * time_s + pitch.phase_rad);
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

bool body_holds(const VehicleScene& vehicle, const VehicleState& state,
                const Eigen::Vector3d& point_m) {
  const BodySize size = body_size(vehicle.kind);
  const Eigen::Vector2d offset_m = point_m.head<2>() - state.place_m;
  const double ahead_m = offset_m.dot(state.forward);
  const double back_m = vehicle.lamps == VehicleLamps::head ? -ahead_m : ahead_m;
  return back_m >= 0.0 && back_m <= size.length_m && point_m.z() <= size.height_m &&
         std::abs(offset_m.dot(left_of(state.forward))) <= 0.5 * size.width_m;
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
