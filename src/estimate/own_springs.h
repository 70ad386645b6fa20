#pragma once

#include <span>

#include "core/quantity.h"
#include "optics/ego_motion.h"
#include "types/site.h"

namespace vildar {

/// Springs lift the nose of a car that speeds up, and let it dive as it brakes, by 1.5 +- 1.2
/// degrees at the acceleration of gravity: prior of kSquat, rad per m/s^2.
inline constexpr Uncertain kUsualSquat{radians_from_degrees(0.15), radians_from_degrees(0.12)};

/// Whether some of these accelerations turn a camera by more than the bearings' noise.
bool springs_work(std::span<const EgoDeviation> own_motion);

/// Of one elevation (rad) among `per_s` bearings a second, for how springs follow the acceleration
/// (known to 15 % of the usual turn), and for how well that is known; alike for a second.
double springs_sigma_rad(const EgoDeviation& own_motion, double per_s);

}  // namespace vildar
