#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "types/result.h"
#include "types/site.h"

namespace vildar {

/// What the vehicles of a clip together say against the site file, for a person to read:
/// - most of them, three or more, do not move as on its road (not_on_road, bad_fit, unobservable);
/// - most that drive, two or more, do so in none of the lanes told for their direction;
/// - of a quantity that vehicles have one by one (lamp height and separation, place in the lane)
///   three or more come out off what is known of it alike: by two sigmas on average, and 4.5 of
///   that mean's (SpeedBudget::prior_pulls). One vehicle may be odd;
/// - three or more of one direction seem to speed up or brake (0.9 and 3), as on a bend that is
///   told the other way.
std::vector<std::string> site_doubts(std::span<const VehicleResult> vehicles, const RoadSite& road);

/// Of vehicles that the camera followed, those that do not move as on the road stated.
struct Elsewhere {
  int count = 0, of = 0;
};

/// Where these are most of `vehicles`, and three or more. A light that is not on the road counts on
/// neither side where it goes along with a measured vehicle of its direction for half of its time:
/// marker lamps, windows.
std::optional<Elsewhere> most_elsewhere(std::span<const VehicleResult> vehicles);

}  // namespace vildar
