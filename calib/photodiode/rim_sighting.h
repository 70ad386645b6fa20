#pragma once

#include <variant>
#include <vector>

#include "calib/photodiode/light_fall.h"
#include "core/quantity.h"
#include "estimate/trajectory.h"
#include "types/site.h"

namespace vildar {

/// One standard deviation of half a photodiode's field of view from what a site file says.
inline constexpr double kRimStd_rad = radians_from_degrees(1.0);

/// Why a photodiode's light of a pass does not tell when its lamps left the view.
enum class Silent {
  rim_not_reached,  ///< they are not seen to come into it, or leave it long after the camera's view
  way_unsure,       ///< the trajectory tells when to no better than 30 ms
  light_does_not_fall,
};

/// One photodiode's light of one pass: the moments at which the lamps may have left its view.
struct RimSighting {
  std::size_t photodiode = 0;
  double way_std_s = 0.0;         ///< of the expected moment, by the trajectory
  double by_rim_s_per_rad = 0.0;  ///< how that moves with half of the field of view
  std::vector<LightFall> falls;   ///< one or more
};

/// Looks for them within `reach_s` of where the site's offset and rim have them, besides what
/// the trajectory leaves open. Two lamps leave the view one after the other; light that is nearly
/// all of one, or of a vehicle that something covers, goes at once: as the light has it.
std::variant<RimSighting, Silent> rim_sighting(const Trajectory& way, const PowerTrace& trace,
                                               const Site& site, double reach_s);

}  // namespace vildar
