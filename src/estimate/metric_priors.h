#pragma once

#include <string>
#include <vector>

#include "estimate/geometry_fit.h"
#include "types/site.h"
#include "types/vehicle_track.h"

namespace vildar {

/// What a vehicle's lamps may be: one class of the site's population, or all of it as one.
struct LampReading {
  std::string id;      ///< of the class; empty where the site names none
  double share = 1.0;  ///< how often it is this, relative to the other readings
  std::optional<Uncertain> height_m, separation_m;
};

/// Readings that the lamps of a track allow; `pairs`: two are seen at once.
std::vector<LampReading> lamp_readings(const LampsSite& lamps, LampKind kind, bool pairs);

/// The site's metric priors for a vehicle of this reading whose lane is not known.
MetricPriors metric_priors(const Site& site, const LampReading& lamps);

/// Lateral offset from the camera in this lane, of what the camera sees of the vehicle.
Uncertain lateral_from_camera_m(const LaneSite& lane, const Site& site, const LampReading& lamps,
                                bool pairs);

}  // namespace vildar
