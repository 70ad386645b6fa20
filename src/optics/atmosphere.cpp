#include "optics/atmosphere.h"

#include <cmath>
#include <stdexcept>

#include "optics/channel.h"

namespace vildar {

double transmittance(double extinction_per_m, Metres distance) {
  if (!(extinction_per_m >= 0.0) || !(distance.value() >= 0.0))
    throw std::domain_error("transmittance: extinction and distance must not be negative");
  return std::exp(-extinction_per_m * distance.value());
}

double extinction_from_visibility_per_m(Metres visibility) {
  if (!(visibility.value() > 0.0))
    throw std::domain_error("extinction_from_visibility_per_m: visibility must be positive");
  return 3.912 / visibility.value();
}

double extinction_of_rain_per_m(double rate_mm_per_h) {
  if (!(rate_mm_per_h >= 0.0))
    throw std::domain_error("extinction_of_rain_per_m: rain rate must not be negative");
  const double loss_db_per_km = 1.076 * std::pow(rate_mm_per_h, 0.67);
  return -std::log(ratio_from_db(-loss_db_per_km)) / 1000.0;
}

}  // namespace vildar
