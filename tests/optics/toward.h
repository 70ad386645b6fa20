#pragma once

#include "core/quantity.h"
#include "optics/lamp_beam.h"

namespace vildar {

/// Luminous intensity, candela, in a direction told in degrees left of and above the lamp's axis.
inline double toward(const LampBeam& beam, double left_deg, double up_deg) {
  return beam.intensity_cd(radians_from_degrees(left_deg), radians_from_degrees(up_deg));
}

}  // namespace vildar
