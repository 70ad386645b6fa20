#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/outcome.h"
#include "estimate/camera_view.h"
#include "estimate/geometry_fit.h"
#include "estimate/motion_change.h"
#include "types/result.h"
#include "types/site.h"
#include "types/vehicle_track.h"

namespace vildar {

/// Posterior of a vehicle's motion at one time.
struct MotionState {
  double range_m = 0.0, range_std_m = 0.0;  ///< x in the road frame
  double lateral_m = 0.0;                   ///< offset from the road's line y = 0
  double closing_mps = 0.0;                 ///< along the path, relative to the camera
  double over_ground_mps = 0.0;             ///< along the path; positive: oncoming
  double speed_std_mps = 0.0;               ///< of over_ground_mps
  double acceleration_mps2 = 0.0;           ///< of over_ground_mps
  double scaled_mps = 0.0;  ///< part of over_ground_mps that all lengths together scale
};

/// A vehicle's fitted trajectory, as one of the things that the vehicle may be.
struct Trajectory {
  GeometryProblem problem;
  GeometryFit fit;
  MotionChange change;
  EgoMotion ego;
  std::string lane;                 ///< whose offset took part as a prior; empty: none
  std::string lamps;                ///< class of the site's lamps; empty where it names none
  double log_prior = 0.0;           ///< ln of how likely this is before anything is seen
  double weight = 1.0;              ///< probability among the trajectories found together
  double from_s = 0.0, to_s = 0.0;  ///< part of the track that it was fitted to
  int frames = 0;
  bool part = false;                       ///< the model does not explain the rest of its track
  BearingOf bearing_of = BearingOf::pair;  ///< what the bearings in `problem` are of
  /// Of its speed, by how drifting to the side misleads the photodiodes' delay in it.
  double drift_std_mps = 0.0;

  MotionState at(double time_s) const;
  double lamp_height_m() const;
  double lateral_m() const;
  /// How far it goes from one side to the other of its line in view; 0 where it keeps to it.
  double crossed_m() const;
  /// Length of its lane from x = 0 to it; the camera stands.
  double along_m(double time_s) const;
  /// Part of the speed's sigma that all parts of its track share: the own speed's, as the site
  /// states it, and on a bend that of a lone lamp, which may be the inner or the outer one of its
  /// vehicle.
  double common_std_mps(double time_s) const;
  /// Relative standard deviation of all lengths together: the share of the metric priors.
  double scale_std() const;
  /// Of a quantity with these slopes by the path's parameters and by the sizes of the steps that
  /// the acceleration takes.
  double std_of(const PathVector& by_path, const Eigen::VectorXd& by_step) const;
};

/// Speed over the ground at `time_s` with its 95 % interval: log-normal for a fixed camera while
/// the relative sigma is below 0.3, else symmetric and cut at zero.
SpeedEstimate speed_estimate(const MotionState& state, double time_s, bool moving_camera,
                             std::int64_t samples);

/// Time within the track at which the shape of the motion tells the speed best (least sigma of
/// speed over scale), of those at which the vehicle drives at 0.3 of its highest speed or more.
double best_time_s(const Trajectory& trajectory, double from_s, double to_s);

/// Fits the bearings of a track: one trajectory for each thing that the vehicle may be (lane, class
/// of lamps) with its weight, the likeliest first. Adds to `warnings` what a reader should know.
/// Misses: too_few_samples, too_short, no_scale, unobservable, not_converged, bad_fit, not_on_road;
/// ambiguous_identity where parts of the track exclude each other.
Outcome<std::vector<Trajectory>> fit_trajectories(const VehicleTrack& track, const Camera& camera,
                                                  const Site& site,
                                                  std::vector<std::string>& warnings);

}  // namespace vildar
