#pragma once

#include <optional>

#include "estimate/trajectory.h"
#include "types/site.h"

namespace vildar {

/// When a lamp of a vehicle leaves a photodiode's field of view, by its trajectory carried on.
struct RimCrossing {
  double time_s = 0.0;  ///< clip time
  /// Of that: what the trajectory leaves open, and 1 m/s^2 from its end on that it does not know
  /// of.
  double std_s = 0.0;
  double by_half_view_s_per_rad = 0.0;  ///< how it moves with half of the field of view
  double distance_m = 0.0;              ///< of the lamp from the photodiode, then
};

/// `side` as in LampObservation. Nothing where the lamp is not in the photodiode's view when the
/// trajectory begins, or leaves it later than 4 s after the trajectory ends.
std::optional<RimCrossing> rim_crossing(const Trajectory& way, double side,
                                        const PhotodiodeSite& photodiode);

}  // namespace vildar
