#include "optics/fresnel.h"

#include <cmath>
#include <stdexcept>

namespace vildar {

double fresnel_reflectance(double cos_incidence, double refractive_index) {
  if (!(cos_incidence >= 0.0 && cos_incidence <= 1.0) || !(refractive_index >= 1.0))
    throw std::domain_error("fresnel_reflectance: needs a cosine in [0, 1] and an index >= 1");
  const double sin_inside_squared =
      (1.0 - cos_incidence * cos_incidence) / (refractive_index * refractive_index);
  const double cos_inside = std::sqrt(1.0 - sin_inside_squared);
  // At grazing incidence on index 1 both are 0: nothing is there to mirror.
  if (cos_inside == 0.0) return 0.0;
  const double across = (cos_incidence - refractive_index * cos_inside) /
                        (cos_incidence + refractive_index * cos_inside);
  const double along = (refractive_index * cos_incidence - cos_inside) /
                       (refractive_index * cos_incidence + cos_inside);
  return 0.5 * (across * across + along * along);
}

double wet_mirror_share(Radians grazing, double film_share) {
  if (!(grazing.value() >= 0.0 && grazing.value() <= 0.5 * kPi) ||
      !(film_share >= 0.0 && film_share <= 1.0))
    throw std::domain_error(
        "wet_mirror_share: needs a grazing angle in [0, pi/2] and a film share in [0, 1]");
  return film_share * fresnel_reflectance(std::sin(grazing.value()), kWaterIndex);
}

}  // namespace vildar
