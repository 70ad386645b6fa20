#pragma once

#include <span>

#include "estimate/trajectory.h"
#include "types/power.h"

namespace vildar {

/// A photodiode's trace between two clip times (`from_s` < `to_s`) with the light of all vehicles
/// but one taken out. `vehicles` are all that shine on it then, as the camera tells their ways,
/// also before it sees them and after: headlamps that come, tail lamps that drive away. `own` is
/// the index of the one that stays.
///
/// Fitted jointly: the ambient level and each vehicle's gain in the site's power law, which may
/// change slowly with the distance. Samples where the light of the others is not known to a small
/// part of the own are left out; `ambient_sigma_w` of the result covers what is not known of it in
/// the rest.
///
/// Misses: no_scale (the site gives no power law), too_few_samples, below_noise (no own light),
/// bad_fit (there is light that none of the vehicles explains).
Outcome<PowerTrace> own_light(const PowerTrace& trace, const Site& site,
                              std::span<const Trajectory* const> vehicles, std::size_t own,
                              double from_s, double to_s);

}  // namespace vildar
