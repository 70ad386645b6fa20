#pragma once

#include <vector>

#include "types/power.h"

namespace vildar {

/// When a lamp's light is expected to go, and its share of what goes in all.
struct LampFall {
  double time_s = 0.0;  ///< photodiode clock
  double share = 1.0;
};

struct ExpectedFall {
  std::vector<LampFall> lamps;  ///< one or more, in order of time
  /// Of a lamp as the photodiode sees it, rad/s: what goes may have faded before by up to 12 nat
  /// per radian or risen by 2, as beam, distance and incidence have it.
  double turn_rad_per_s = 0.0;
};

/// A moment at which light falls as where lamps leave a photodiode's view one after the other.
struct LightFall {
  double late_s = 0.0;  ///< after the expected times
  double std_s = 0.0;
  double sigmas = 0.0;  ///< by which light that changes smoothly does not explain it
};

/// Where in a trace the light may fall as expected, all late by at most `reach_s` or early by as
/// much. Those that stand out by ten sigmas or more, each the clearest within 20 ms of itself.
std::vector<LightFall> light_falls(const PowerTrace& trace, const ExpectedFall& expected,
                                   double reach_s);

}  // namespace vildar
