#include "optics/radar_limit.h"

#include <cmath>
#include <stdexcept>

namespace vildar {

double radar_share_straight(Metres range, Metres perpendicular) {
  return std::cos(straight_place(range, perpendicular).incidence_rad);
}

double radar_share_curved(const PaperCurve& curve, Radians arc_angle) {
  const PaperPlace place = curved_place(curve, arc_angle);
  return std::sin(0.5 * kPi - arc_angle.value() + std::atan2(place.perpendicular_m, place.range_m));
}

double radar_share_straight_window(Metres range, Metres travelled, Metres perpendicular) {
  if (!(travelled.value() > 0.0))
    throw std::domain_error("radar_share_straight_window: the window must have a length");
  const double d_m = perpendicular.value();
  return (std::hypot(range.value() + travelled.value(), d_m) - std::hypot(range.value(), d_m)) /
         travelled.value();
}

double radar_share_corrected(Metres range, Metres perpendicular, Metres assumed) {
  const PaperPlace place = straight_place(range, perpendicular);
  const double ratio = assumed.value() / place.distance_m;
  if (!(range.value() > 0.0 && std::abs(ratio) < 1.0))
    throw std::domain_error("radar_share_corrected: the vehicle must be ahead of the sensor");
  return std::cos(place.incidence_rad) / std::sqrt((1.0 - ratio) * (1.0 + ratio));
}

}  // namespace vildar
