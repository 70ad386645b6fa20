#include "optics/ego_motion.h"

#include <algorithm>
#include <cmath>

#include "optics/road.h"

namespace vildar {

EgoMotion::EgoMotion(const EgoSite& site, const RoadSite& road)
    : site_(site), moving_(true), turns_known_(site.turns_known()) {
  if (road.radius_m) road_curvature_per_m_ = bend_of(road) / road.radius_m->mean;
  straight_m_ = road.straight_m;
  if (turns_known_) curvature_per_m_ = road_curvature_per_m_;
}

double EgoMotion::interpolated(double time_s, double EgoSample::*field) const {
  const auto& trace = site_.trace;
  const auto above = std::lower_bound(
      trace.begin(), trace.end(), time_s,
      [](const EgoSample& sample, double wanted_s) { return sample.time_s < wanted_s; });
  if (above == trace.begin()) return trace.front().*field;
  if (above == trace.end()) return trace.back().*field;
  const EgoSample& below = *(above - 1);
  const double share = (time_s - below.time_s) / (above->time_s - below.time_s);
  return (1.0 - share) * (below.*field) + share * ((*above).*field);
}

double EgoMotion::speed_mps(double time_s) const {
  if (!moving_) return 0.0;
  return site_.trace.empty() ? site_.speed_mps.mean : interpolated(time_s, &EgoSample::speed_mps);
}

template <class TurnRate>
DrivenPose EgoMotion::driven(DrivenPose pose, double to_s,
                             const TurnRate& turn_rate_rad_per_s) const {
  // Traces are given at 1 to 50 Hz; stamps may jump by years.
  constexpr double kStep_s = 0.02, kMostSteps = 1e5;
  const double from_s = pose.time_s, span_s = to_s - from_s;
  const double steps = std::clamp(std::ceil(std::abs(span_s) / kStep_s), 1.0, kMostSteps);
  const double step_s = span_s / steps;
  for (double step = 0.5; step < steps; ++step) {
    const double middle_s = from_s + step * step_s;
    const double length_m = speed_mps(middle_s) * step_s;
    const double turn_rad = turn_rate_rad_per_s(middle_s, pose.way_m) * step_s;
    const double middle_rad = pose.heading_rad + 0.5 * turn_rad;
    pose.x_m += length_m * std::cos(middle_rad);
    pose.y_m += length_m * std::sin(middle_rad);
    pose.heading_rad += turn_rad;
    pose.way_m += length_m;
  }
  pose.time_s = to_s;
  return pose;
}

DrivenPose EgoMotion::driven(const DrivenPose& from, double to_s) const {
  return driven(from, to_s, [this](double time_s, double way_m) {
    if (turns_known_) return interpolated(time_s, &EgoSample::yaw_rate_rad_per_s);
    return way_m < straight_m_ ? 0.0 : road_curvature_per_m_ * speed_mps(time_s);
  });
}

EgoDeviation EgoMotion::deviation(double reference_s, double time_s) const {
  EgoDeviation deviation;
  deviation.curvature_per_m = curvature_per_m_;
  if (!moving_ || site_.trace.empty()) return deviation;
  const DrivenPose pose = driven({.time_s = reference_s}, time_s, [this](double at_s, double) {
    if (!turns_known_) return 0.0;
    return interpolated(at_s, &EgoSample::yaw_rate_rad_per_s) - curvature_per_m_ * speed_mps(at_s);
  });
  deviation.ahead_m = pose.x_m - speed_mps(reference_s) * (time_s - reference_s);
  deviation.left_m = pose.y_m;
  deviation.heading_rad = pose.heading_rad;
  if (turns_known_) deviation.way_m = pose.way_m;
  return deviation;
}

bool EgoMotion::covers(double from_s, double to_s) const {
  if (site_.trace.empty()) return true;
  return site_.trace.front().time_s <= from_s && to_s <= site_.trace.back().time_s;
}

}  // namespace vildar
