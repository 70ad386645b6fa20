#pragma once

#include <string>
#include <vector>

#include "types/site.h"

namespace vildar {

/// Where the yaw rates of a dashcam's own vehicle and the road of the site file contradict each
/// other: from the first to the last quarter of 8 s (or of the clip) it turns off the road's line
/// by 0.15 rad (8.6 degrees) or more, and by more than one does who changes lanes; 2.5 sigmas of a
/// bend's radius are allowed for. One warning for the place in [0, to_s] where it turns most; none
/// without yaw rates, beyond the trace's ends, or where the bend begins ahead (straight_m).
/// to_s >= 0.
std::vector<std::string> turns_off_the_road(const Site& site, double to_s);

}  // namespace vildar
