#include "estimate/offset.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

#include "estimate/mixture.h"

namespace vildar {
namespace {

template <class At>
Offset offset(const VehicleEstimate& one, const VehicleEstimate& other, double time_s, At at) {
  constexpr double kStep_s = 0.05;
  // What is left between two views of one vehicle beside the sigmas: another part of its body.
  constexpr double kFloor_m = 0.5;
  // Slower relative to the camera, which way it drives is not told; taken to be the road's.
  constexpr double kLeast_mps = 3.0;
  const MotionState a = at(one, time_s), b = at(other, time_s), later = at(one, time_s + kStep_s);
  const Eigen::Vector2d off_m(a.range_m - b.range_m, a.lateral_m - b.lateral_m);
  Eigen::Vector2d way(later.range_m - a.range_m, later.lateral_m - a.lateral_m);
  way = way.norm() > kLeast_mps * kStep_s ? Eigen::Vector2d(way.normalized())
                                          : Eigen::Vector2d::UnitX();
  return {off_m.dot(way), off_m.x() * way.y() - off_m.y() * way.x(),
          std::hypot(a.range_std_m, b.range_std_m, kFloor_m)};
}

}  // namespace

Offset offset_at(const VehicleEstimate& one, const VehicleEstimate& other, double time_s) {
  return offset(one, other, time_s, [](const VehicleEstimate& vehicle, double at_s) {
    return mixed_state(vehicle.trajectories, at_s);
  });
}

Offset scaled_offset_at(const VehicleEstimate& one, const VehicleEstimate& other, double time_s) {
  return offset(one, other, time_s, [](const VehicleEstimate& vehicle, double at_s) {
    const Trajectory& likeliest = vehicle.trajectories.front();
    MotionState state = likeliest.at(at_s);
    const double scale_m = likeliest.scale_std() * state.range_m;
    state.range_std_m =
        std::sqrt(std::max(0.0, state.range_std_m * state.range_std_m - scale_m * scale_m));
    return state;
  });
}

}  // namespace vildar
