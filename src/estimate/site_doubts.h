#pragma once

#include <span>
#include <string>
#include <vector>

#include "types/result.h"
#include "types/site.h"

namespace vildar {

/// Of each known quantity that vehicles have one by one (lamp height, lamp separation, place in
/// the lane): whether the measured ones come out off what the site file says of it more alike than
/// vehicles differ: by more than two of its standard deviations on average, and 4.5 of that mean's.
/// One vehicle may be odd; three in one direction say that the site is. And whether all seem to
/// speed up or brake alike (0.9 and 2.5), as on a bend that the site file tells the other way. At
/// most one warning each.
/// And whether most that drive, two or more, do so in none of the lanes told.
std::vector<std::string> site_doubts(std::span<const VehicleResult> vehicles, const RoadSite& road);

}  // namespace vildar
