#pragma once

#include <optional>

#include "estimate/power_method.h"
#include "estimate/trajectory.h"
#include "types/power.h"

namespace vildar {

/// Lane, lamp height and path of a vehicle as its power methods need them.
struct VehiclePlace {
  Uncertain lateral_m;
  Uncertain lamp_height_m;
};
VehiclePlace place_of(const Trajectory& trajectory);
/// From the site alone: a lane and the site's lamp height; nothing where the height is not given.
std::optional<VehiclePlace> place_of(const LaneSite& lane, const Site& site);

/// The site's channel as the paper's power law for one photodiode.
/// Misses: no_scale where gain or exponent is not given, outside_model where a beam replaces them.
Outcome<PowerCase> photodiode_case(const Site& site, int photodiode, const VehiclePlace& place);

/// A stretch of a trace in which the paper's estimators hold: clearly above the noise, approaching,
/// and within 30 degrees of incidence (straight roads); times in clip time.
struct VehicleLight {
  /// Less the ambient of the trace, and as sure as that is.
  PowerSeries series;
  /// The same less the ambient that the light itself tells, where that of the trace is unsure:
  /// where the record shows no dark moment. For estimators that cannot find it themselves: its
  /// sigma holds all that is not known of the vehicle, which they then count once more.
  PowerSeries cleared;
};

/// `from_s` and `to_s` are in clip time; with a trajectory the incidence is its, else that of the
/// power itself.
VehicleLight vehicle_light(const PowerTrace& trace, const Site& site, const PowerCase& known,
                           double from_s, double to_s, const Trajectory* trajectory);

}  // namespace vildar
