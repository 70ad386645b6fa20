#pragma once

#include "core/quantity.h"

namespace vildar {

/// Share of light that is left after `distance` of air: exp(-extinction * distance). Both >= 0;
/// throws std::domain_error otherwise.
double transmittance(double extinction_per_m, Metres distance);

/// Extinction of fog or haze with this meteorological visibility (Koschmieder, 2 % contrast):
/// 3.912 / V. V > 0; throws std::domain_error otherwise.
double extinction_from_visibility_per_m(Metres visibility);

/// Extinction by rain that falls at this rate: 1.076 R^0.67 dB/km, R in millimetres an hour, >= 0;
/// throws std::domain_error otherwise.
double extinction_of_rain_per_m(double rate_mm_per_h);

}  // namespace vildar
