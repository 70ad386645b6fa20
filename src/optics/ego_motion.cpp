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

EgoDeviation EgoMotion::deviation(double reference_s, double time_s) const {
  EgoDeviation deviation;
  deviation.curvature_per_m = curvature_per_m_;
  if (!moving_ || site_.trace.empty()) return deviation;
  const double span_s = time_s - reference_s;
  constexpr double kStep_s = 0.02;  // traces are given at 1 to 50 Hz
  const int steps = std::max(1, static_cast<int>(std::ceil(std::abs(span_s) / kStep_s)));
  const double step_s = span_s / steps;
  for (int i = 0; i < steps; ++i) {
    const double middle_s = reference_s + (i + 0.5) * step_s;
    const double length_m = speed_mps(middle_s) * step_s;
    double turn_rad = 0.0;
    if (turns_known_) {
      turn_rad = interpolated(middle_s, &EgoSample::yaw_rate_rad_per_s) * step_s -
                 curvature_per_m_ * length_m;
      deviation.way_m += length_m;
    }
    const double middle_rad = deviation.heading_rad + 0.5 * turn_rad;
    deviation.ahead_m += length_m * std::cos(middle_rad);
    deviation.left_m += length_m * std::sin(middle_rad);
    deviation.heading_rad += turn_rad;
  }
  deviation.ahead_m -= speed_mps(reference_s) * span_s;
  return deviation;
}

double EgoMotion::turn_rate_rad_per_s(double time_s, double way_m) const {
  if (turns_known_) return interpolated(time_s, &EgoSample::yaw_rate_rad_per_s);
  return way_m < straight_m_ ? 0.0 : road_curvature_per_m_ * speed_mps(time_s);
}

bool EgoMotion::covers(double from_s, double to_s) const {
  if (site_.trace.empty()) return true;
  return site_.trace.front().time_s <= from_s && to_s <= site_.trace.back().time_s;
}

}  // namespace vildar
