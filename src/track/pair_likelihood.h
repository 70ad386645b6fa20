#pragma once

#include "track/lamp.h"
#include "track/road_view.h"

namespace vildar {

/// What one frame says on whether two lamps are those of one vehicle.
struct PairLook {
  double chi2 = 0.0;  ///< misfit of one vehicle, about 6 degrees of freedom
  /// Natural log of the likelihood of what is seen if they are one vehicle's over that if they are
  /// lamps of their own that happen to be neighbours.
  double log_odds = 0.0;
  PairFit fit;
};

/// The lamps must have been seen in the present frame.
PairLook look_at_pair(const Lamp& a, const Lamp& b, const RoadView& view);

/// Whether `third` stands between two lamps, level with them and not outshone.
bool stands_between(const Lamp& third, const Lamp& a, const Lamp& b);

}  // namespace vildar
