#pragma once

#include "types/result.h"

namespace vildar {

/// Whether a speed is known well enough to stand by: within 25 % or within 3 m/s, one sigma.
inline bool useful(const SpeedEstimate& speed) {
  constexpr double kShare = 0.25;
  constexpr double kAbsolute_mps = 3.0;
  return speed.std_mps <= kShare * speed.speed_mps || speed.std_mps <= kAbsolute_mps;
}

}  // namespace vildar
