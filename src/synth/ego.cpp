#include "synth/ego.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "core/quantity.h"
#include "core/random.h"
#include "optics/camera.h"
#include "optics/road.h"

namespace vildar {
namespace {

// No two in a simple ratio, so that the sum does not repeat within a clip.
constexpr double kFrequencyShares[] = {0.41, 0.73, 1.0, 1.47, 2.13};

double interpolated(const std::vector<EgoSample>& trace, double time_s, double EgoSample::*field) {
  const auto above =
      std::lower_bound(trace.begin(), trace.end(), time_s,
                       [](const EgoSample& sample, double at_s) { return sample.time_s < at_s; });
  if (above == trace.begin()) return trace.front().*field;
  if (above == trace.end()) return trace.back().*field;
  const EgoSample& below = *(above - 1);
  const double share = (time_s - below.time_s) / (above->time_s - below.time_s);
  return (1.0 - share) * (below.*field) + share * ((*above).*field);
}

Eigen::Rotation2Dd turn_of(double heading_rad) { return Eigen::Rotation2Dd(heading_rad); }

}  // namespace

Eigen::Vector2d EgoPose::seen_m(const Eigen::Vector2d& point_m) const {
  return turned(point_m - place_m);
}
Eigen::Vector2d EgoPose::still_m(const Eigen::Vector2d& seen_m) const {
  return heading_rad == 0.0 ? Eigen::Vector2d(place_m + seen_m)
                            : Eigen::Vector2d(place_m + turn_of(heading_rad) * seen_m);
}
Eigen::Vector2d EgoPose::turned(const Eigen::Vector2d& direction) const {
  return heading_rad == 0.0 ? direction : Eigen::Vector2d(turn_of(-heading_rad) * direction);
}

EgoPose ego_pose(const Site& site, double time_s) {
  EgoPose pose;
  if (!site.ego) return pose;
  const EgoSite& ego = *site.ego;
  const bool turns_known = ego.turns_known();
  double way_m = 0.0;
  if (ego.trace.empty()) {
    way_m = ego.speed_mps.mean * time_s;
  } else {
    constexpr double kLongestStep_s = 0.01;
    const int steps = std::max(1, static_cast<int>(std::ceil(std::abs(time_s) / kLongestStep_s)));
    const double step_s = time_s / steps;
    for (int i = 0; i < steps; ++i) {
      const double middle_s = (i + 0.5) * step_s;
      const double length_m = interpolated(ego.trace, middle_s, &EgoSample::speed_mps) * step_s;
      way_m += length_m;
      if (!turns_known) continue;
      const double turn_rad =
          interpolated(ego.trace, middle_s, &EgoSample::yaw_rate_rad_per_s) * step_s;
      const double along_rad = pose.heading_rad + 0.5 * turn_rad;
      pose.place_m += length_m * Eigen::Vector2d(std::cos(along_rad), std::sin(along_rad));
      pose.heading_rad += turn_rad;
    }
  }
  if (turns_known) return pose;
  const RoadSite& road = site.road;
  const PathPoint<double> point =
      road.radius_m
          ? path_point(way_m, 0.0, bend_of(road), road.straight_m.mean, road.radius_m->mean)
          : PathPoint<double>{way_m, 0.0, 0.0};
  return {{point.x_m, point.y_m}, point.heading_rad};
}

CameraShake::CameraShake(const Scenario& scenario) : scene_(scenario.shake) {
  if (scenario.site.camera) camera_m_ = Camera(*scenario.site.camera).position_m();
  Random random(scenario.seed ^ 0x7368616b65ULL);
  for (int axis = 0; axis < 2; ++axis)
    for (int i = 0; i < kSines; ++i) phase_rad_(i, axis) = random.uniform(0.0, 2.0 * kPi);
}

Eigen::Vector2d CameraShake::turn_rad(double time_s) const {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (int i = 0; i < kSines; ++i)
    for (int axis = 0; axis < 2; ++axis)
      sum[axis] += std::sin(2.0 * kPi * scene_.frequency_hz * kFrequencyShares[i] * time_s +
                            phase_rad_(i, axis));
  return std::sqrt(2.0 / kSines) *
         sum.cwiseProduct(Eigen::Vector2d(scene_.yaw_std_rad, scene_.pitch_std_rad));
}

Eigen::Vector3d CameraShake::steady_m(const Eigen::Vector3d& point_m, double time_s) const {
  if (still()) return point_m;
  const Eigen::Vector2d turn = turn_rad(time_s);
  const Eigen::Matrix3d shaken = (Eigen::AngleAxisd(turn[0], Eigen::Vector3d::UnitZ()) *
                                  Eigen::AngleAxisd(-turn[1], Eigen::Vector3d::UnitY()))
                                     .toRotationMatrix();
  return camera_m_ + shaken.transpose() * (point_m - camera_m_);
}

}  // namespace vildar
