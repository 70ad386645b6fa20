#include "estimate/path_start.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "core/median.h"

namespace vildar {
namespace {

// The rays of one sighting, road axes, of length one along the viewing axis.
struct Rays {
  double time_s = 0.0;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  double width = 0.0;  // between the lamps of a pair; 0 where one lamp is seen
};

std::vector<Rays> rays_of(const CameraView& view, const PathSetting& setting) {
  std::vector<Rays> all;
  const Eigen::Matrix3d road_from_camera = setting.camera_from_road.transpose();
  for (std::size_t i = 0; i < view.lamps.size(); ++i) {
    const LampObservation& lamp = view.lamps[i];
    Rays rays;
    rays.time_s = lamp.time_s;
    rays.middle = road_from_camera * lamp.normalized.homogeneous();
    if (i + 1 < view.lamps.size() && view.lamps[i + 1].sighting == lamp.sighting) {
      const LampObservation& other = view.lamps[++i];
      rays.middle = road_from_camera * (0.5 * (lamp.normalized + other.normalized)).homogeneous();
      rays.width = (lamp.normalized - other.normalized).norm();
    }
    all.push_back(rays);
  }
  return all;
}

template <class Scale>
RoughPath scaled(const std::vector<Rays>& rays, Scale scale_of) {
  RoughPath path;
  constexpr double kFarthest_m = 1000.0;
  for (const Rays& ray : rays) {
    const double scale_m = scale_of(ray);
    if (!(scale_m > 0.0) || !(scale_m < kFarthest_m)) continue;
    const Eigen::Vector3d point_m = scale_m * ray.middle;
    path.push_back({ray.time_s, point_m.head<2>(), -point_m.z(), scale_m * ray.width});
  }
  // Readings that fail for a good part of the track are no start.
  if (path.size() < 3 || 2 * path.size() < rays.size()) path.clear();
  return path;
}

// Of values along a way, each by its weight, the line that they lie on: its height and its slope.
struct Line {
  double at_zero = 0.0, slope = 0.0;
};
Line line_through(const std::vector<double>& value, const std::vector<double>& along,
                  const std::vector<double>& weight) {
  double w = 0.0, wx = 0.0, wxx = 0.0, wy = 0.0, wxy = 0.0;
  for (std::size_t i = 0; i < value.size(); ++i) {
    w += weight[i];
    wx += weight[i] * along[i];
    wxx += weight[i] * along[i] * along[i];
    wy += weight[i] * value[i];
    wxy += weight[i] * along[i] * value[i];
  }
  const double determinant = w * wxx - wx * wx;
  if (!(determinant > 0.0)) return {median(value), 0.0};
  const double slope = (w * wxy - wx * wy) / determinant;
  return {(wy - slope * wx) / w, slope};
}

double weight_of(const RoughPoint& point) { return 1.0 / (1.0 + point.place_m.squaredNorm()); }

}  // namespace

std::vector<RoughPath> rough_paths(const CameraView& view, const PathSetting& setting,
                                   const NominalSizes& sizes) {
  const std::vector<Rays> rays = rays_of(view, setting);
  std::vector<RoughPath> paths;
  const auto add = [&](RoughPath path) {
    if (!path.empty()) paths.push_back(std::move(path));
  };
  add(scaled(rays, [&](const Rays& ray) { return -sizes.drop_m / ray.middle.z(); }));
  std::vector<Rays> paired;
  std::ranges::copy_if(rays, std::back_inserter(paired),
                       [](const Rays& ray) { return ray.width > 0.0; });
  if (!paired.empty())
    add(scaled(paired, [&](const Rays& ray) { return sizes.separation_m / ray.width; }));
  if (sizes.lateral_m && setting.bend == 0.0)
    add(scaled(rays, [&](const Rays& ray) { return *sizes.lateral_m / ray.middle.y(); }));
  return paths;
}

double reference_time_s(const RoughPath& path) {
  double sum_s = 0.0, weight = 0.0;
  for (const RoughPoint& point : path) {
    sum_s += weight_of(point) * point.time_s;
    weight += weight_of(point);
  }
  return sum_s / weight;
}

std::optional<PathVector> start_of(const RoughPath& path, const GeometryProblem& problem,
                                   const RoadSite& road, const EgoMotion& ego,
                                   const NominalSizes& sizes, Look look) {
  const PathSetting& setting = problem.setting;
  const double reference_s = problem.reference_s;
  const double off_rad = problem.ego_unknowns[0].mean;
  double w = 0.0, wt = 0.0, wx = 0.0, wtt = 0.0, wtx = 0.0;
  std::vector<double> lateral_m, drop_m, separation_m, forward_m, weights;
  for (const RoughPoint& point : path) {
    EgoDeviation moved = ego.deviation(reference_s, point.time_s);
    moved.heading_rad += off_rad;
    moved.ahead_m += (std::cos(off_rad) - 1.0) * moved.along_m - std::sin(off_rad) * moved.left_m;
    moved.left_m = std::sin(off_rad) * moved.along_m + std::cos(off_rad) * moved.left_m;
    const Eigen::Vector2d seen_m = point.place_m + setting.camera_m.head<2>();
    const double c = std::cos(moved.heading_rad), s = std::sin(moved.heading_rad);
    const RoadPosition place = road_position(road, c * seen_m.x() - s * seen_m.y(),
                                             s * seen_m.x() + c * seen_m.y() + moved.left_m);
    double lane_share = 1.0;
    if (setting.bend != 0.0) lane_share -= setting.bend * place.lateral_m / sizes.radius_m;
    const double along_m = place.along_m + lane_share * moved.ahead_m - setting.camera_m.x();
    const double weight = weight_of(point) * weight_of(point);
    const double tau_s = point.time_s - reference_s;
    w += weight;
    wt += weight * tau_s;
    wx += weight * along_m;
    wtt += weight * tau_s * tau_s;
    wtx += weight * tau_s * along_m;
    lateral_m.push_back(place.lateral_m - setting.camera_m.y());
    drop_m.push_back(point.drop_m);
    forward_m.push_back(along_m);
    weights.push_back(weight);
    if (point.separation_m > 0.0) separation_m.push_back(point.separation_m);
  }
  const double determinant = w * wtt - wt * wt;
  if (!(determinant > 0.0)) return std::nullopt;
  const double rate_mps = (w * wtx - wt * wx) / determinant;
  const double distance_m = (wx - rate_mps * wt) / w;
  if (!(distance_m > 0.1)) return std::nullopt;
  PathVector start = PathVector::Zero();
  start[kLogScale] = std::log(distance_m);
  start[kClosingRate] = -rate_mps / distance_m;
  start[kLateral] = median(lateral_m) / distance_m;
  start[kDrop] = median(drop_m) / distance_m;
  const std::array<Uncertain, 3>& turn_rad = problem.priors.turn_rad;
  if (look == Look::by_path && turn_rad[0].std > 0.0) {
    const Line line = line_through(lateral_m, forward_m, weights);
    start[kLateral] = line.at_zero / distance_m;
    start[kYaw] = -line.slope;
  }
  if (look == Look::by_path && turn_rad[1].std > 0.0) {
    const Line line = line_through(drop_m, forward_m, weights);
    start[kDrop] = line.at_zero / distance_m;
    start[kPitch] = line.slope;
  }
  const double width_m = separation_m.empty() ? sizes.separation_m : median(separation_m);
  start[kLogSeparation] = std::log(width_m / distance_m);
  start[kHeading] = off_rad;
  if (setting.bend != 0.0) start[kLogRadius] = std::log(sizes.radius_m / distance_m);
  start[kStraight] = setting.straight_m / distance_m;
  return start;
}

}  // namespace vildar
