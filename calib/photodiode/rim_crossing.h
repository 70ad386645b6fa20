#pragma once

#include <optional>

#include "estimate/trajectory.h"
#include "types/site.h"

namespace vildar {

/// When a lamp of a vehicle leaves a photodiode's field of view, by its trajectory carried on.
struct RimCrossing {
  double time_s = 0.0;                  ///< clip time
  double std_s = 0.0;                   ///< of that, by what the trajectory leaves open
  double by_half_view_s_per_rad = 0.0;  ///< how it moves with half of the field of view
  double distance_m = 0.0;              ///< of the lamp from the photodiode, then
};

/// `side` as in LampObservation. Nothing where the lamp is not in view at the trajectory's end, or
/// leaves it later than in 4 s.
std::optional<RimCrossing> rim_crossing(const Trajectory& way, double side,
                                        const PhotodiodeSite& photodiode);

}  // namespace vildar
