#include "optics/channel.h"

#include <cmath>
#include <stdexcept>

namespace vildar {

double lambertian_order(Radians half_power_angle) {
  const double angle_rad = half_power_angle.value();
  if (!(angle_rad > 0.0 && angle_rad < 0.5 * kPi))
    throw std::domain_error("lambertian_order: half-power angle must lie between 0 and 90 degrees");
  return -std::log(2.0) / std::log(std::cos(angle_rad));
}

double lambertian_gain(double order, double area_m2) {
  return (order + 1.0) * area_m2 / (2.0 * kPi);
}

double ratio_from_db(double gain_db) { return std::pow(10.0, 0.1 * gain_db); }
double db_from_ratio(double ratio) { return 10.0 * std::log10(ratio); }

double PowerLaw::power_w(double range_m, double perpendicular_m) const {
  const double distance_m = std::hypot(range_m, perpendicular_m);
  if (!(distance_m > 0.0)) throw std::domain_error("PowerLaw: distance must be positive");
  double power = gain_w * std::pow(distance_m, -path_loss_exponent);
  if (cosine_exponent > 0.0)
    power *= range_m > 0.0 ? std::pow(range_m / distance_m, cosine_exponent) : 0.0;
  return power;
}

}  // namespace vildar
