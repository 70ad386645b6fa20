#pragma once

#include "estimate/trajectory.h"
#include "estimate/vehicle.h"
#include "types/result.h"
#include "types/site.h"
#include "types/vehicle_track.h"

namespace vildar {

/// The paper's estimators on the camera's per-frame intensity. Frames with clipped pixels or fewer
/// lamps than the vehicle has are left out. K is the site's, or without one is fitted to the
/// trajectory's own distances. `trajectory` is null where the bearings gave none.
MethodResult camera_intensity_method(const VehicleTrack& track, const Site& site,
                                     const Trajectory* trajectory);

/// The paper's estimators on the photodiodes' power during the track: that of the photodiode which
/// gives the smallest sigma. `power` is not empty.
std::vector<MethodResult> photodiode_methods(const VehicleTrack& track, const Site& site,
                                             std::span<const VehiclePower> power,
                                             const Trajectory* trajectory);

}  // namespace vildar
