#pragma once

#include "core/quantity.h"

namespace vildar {

inline constexpr double kWaterIndex = 1.33;

/// Share of unpolarised light that a smooth surface of a transparent medium mirrors, coming from
/// air at an angle with this cosine to the normal. 0 <= cosine <= 1, index >= 1; throws
/// std::domain_error otherwise.
double fresnel_reflectance(double cos_incidence, double refractive_index);

/// How bright the mirror image of a lamp in a wet road is beside the lamp itself: the share of the
/// surface under a closed film of water times its reflectance. `grazing` is the angle between ray
/// and road, 0 to pi/2; the film share 0 to 1; throws std::domain_error otherwise. The image stands
/// as far below the road as the lamp stands above, and the lamp's beam is to be taken toward the
/// mirroring point.
double wet_mirror_share(Radians grazing, double film_share);

}  // namespace vildar
