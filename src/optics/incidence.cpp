#include "optics/incidence.h"

#include <cmath>
#include <stdexcept>

namespace vildar {

PaperPlace straight_place(Metres range, Metres perpendicular) {
  PaperPlace place{range.value(), perpendicular.value(), 0.0, 0.0};
  place.distance_m = std::hypot(place.range_m, place.perpendicular_m);
  if (!(place.distance_m > 0.0))
    throw std::domain_error("straight_place: distance must be positive");
  place.incidence_rad = std::atan2(std::abs(place.perpendicular_m), place.range_m);
  return place;
}

PaperPlace curved_place(const PaperCurve& curve, Radians arc_angle) {
  if (!(curve.radius_m > 0.0)) throw std::domain_error("curved_place: radius must be positive");
  const double beta_rad = arc_angle.value();
  // 1 - cos(beta), without its cancellation near the end of the arc.
  const double half_sine = std::sin(0.5 * beta_rad);
  return straight_place(Metres(curve.straight_m + curve.radius_m * std::sin(beta_rad)),
                        Metres(curve.lateral_m + 2.0 * curve.radius_m * half_sine * half_sine));
}

Eigen::Vector3d axis_of(const PhotodiodeSite& photodiode) {
  const double level = std::cos(photodiode.pitch_rad);
  return {level * std::cos(photodiode.yaw_rad), level * std::sin(photodiode.yaw_rad),
          std::sin(photodiode.pitch_rad)};
}

}  // namespace vildar
