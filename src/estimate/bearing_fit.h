#pragma once

#include <vector>

#include "estimate/metric_priors.h"
#include "estimate/residual_check.h"
#include "estimate/trajectory.h"

namespace vildar {

/// A first fit of a track's bearings, with the site's commonest lamps and no lane (but the only
/// one, where nothing else has a scale), and what its residuals say.
struct BearingFit {
  Trajectory trajectory;
  ResidualCheck check;
  std::vector<LampReading> readings;
  bool scaled = false;  ///< something but a lane fixes the scale
  /// More scatter is not that of lamps; before a camera that drives, and pitches, upright more is.
  Eigen::Vector2d most_scatter_px = Eigen::Vector2d::Zero();

  /// Whether the model explains the bearings at all, by a motion that tyres can give.
  bool explains() const;
  /// The same, and nothing slow is left that another motion would explain better.
  bool steady() const;
  /// Whether beside a bend it weaves by more than one who keeps to a lane.
  bool leaves_lane() const;
  /// Whether how far apart its lamps are seen tells its motion, and better than where they are.
  bool told_apart() const;
};

/// Before which cameras a driver's way to and fro within the lane is an unknown of a fit: those
/// that weave_counts() names, or all that stand.
enum class Weave { where_told, allowed };

/// Misses: too_few_samples, too_short, no_scale, unobservable, not_converged, not_on_road.
Outcome<BearingFit> fit_bearings(const VehicleTrack& track, const Camera& camera, const Site& site,
                                 Weave weave = Weave::where_told);

/// The same of a pair that changes lanes: its speed along the road may change evenly and wander
/// somewhat, its place across it as the bearings ask for.
/// Misses: bad_fit as well, where it would go across by more than from lane to lane, or on a
/// straight road by less than kAcrossALane_m: a camera that sways slowly looks like that.
Outcome<BearingFit> fit_lane_change(const VehicleTrack& track, const Camera& camera,
                                    const Site& site);

}  // namespace vildar
