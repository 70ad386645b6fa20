#pragma once

#include "estimate/vehicle.h"

namespace vildar {

/// How far one vehicle is from another.
struct Offset {
  double along_m, beside_m, sigma_m;  ///< along the way of the first, and across it
};

/// At `time_s`, as their speeds from the camera say. Both have one.
Offset offset_at(const VehicleEstimate& one, const VehicleEstimate& other, double time_s);

/// The same by the likeliest thing that each may be, and as if the scale of all lengths were known:
/// of one vehicle that is seen twice, as the same thing, it is wrong alike.
Offset scaled_offset_at(const VehicleEstimate& one, const VehicleEstimate& other, double time_s);

}  // namespace vildar
