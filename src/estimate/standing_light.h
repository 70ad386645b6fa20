#pragma once

#include "estimate/trajectory.h"
#include "types/result.h"
#include "types/site.h"
#include "types/vehicle_track.h"

namespace vildar {

/// Before a camera that stands: lights that stay where they are all the time are letters burnt into
/// the picture, signs and street lamps, if no parked car.
bool stands_all_the_time(const VehicleTrack& track, const Site& site, const Trajectory& trajectory,
                         const SpeedEstimate& speed);

/// Before a camera that drives: a light without a partner whose 95 % interval reaches down to 0.3
/// m/s is as well a reflector or a lamp by the road.
bool may_be_a_post(const VehicleTrack& track, const Site& site, const SpeedEstimate& speed);

}  // namespace vildar
