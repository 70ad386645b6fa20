#pragma once

#include <cmath>
#include <span>

#include "estimate/delay_fit.h"
#include "types/power.h"
#include "types/site.h"

namespace vildar {

/// A pass as the photodiode shows it that sees it best.
struct SeenPass {
  const PowerTrace* trace = nullptr;
  PowerPass pass;
  double peak_w = 0.0;  ///< above ambient
};

/// `found` in the light of any of the photodiodes; `traces`, one or more, outlive the result.
SeenPass best_seen(const PowerPass& found, const Site& site, std::span<const PowerTrace> traces);

/// Speed of a pass by the delay between photodiodes, at the surest of the clip times asked for.
/// What light others leave behind it widens its sigma. `lanes`: that the vehicle may drive in.
/// Misses: several_vehicles where one vehicle does not explain the light, and those of
/// delay_speed().
Outcome<DelayFit> pass_delay(const SeenPass& seen, const Site& site,
                             std::span<const PowerTrace> traces, std::size_t lanes,
                             double asked_from_s = -INFINITY, double asked_to_s = INFINITY);

}  // namespace vildar
