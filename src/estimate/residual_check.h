#pragma once

#include <limits>
#include <vector>

#include "estimate/geometry_fit.h"

namespace vildar {

/// What the residuals of a fit say about the observations' sigmas.
struct ResidualCheck {
  /// Factor by which each axis' sigmas must grow so that the covariance holds: scatter beyond the
  /// nominal, times what correlation in time and between the two lamps of a frame takes away.
  Eigen::Vector2d sigma_factor = Eigen::Vector2d::Ones();
  Eigen::Vector2d scatter_px = Eigen::Vector2d::Zero();  ///< robust, per axis
  double outlier_share = 0.0;                            ///< observations beyond four robust sigmas
  /// Factor that the scatter from frame to frame alone asks for, which no motion of a vehicle
  /// makes.
  Eigen::Vector2d quick_factor = Eigen::Vector2d::Ones();
  /// As sigma_factor, and as quick_factor, of how far apart the two lamps of a frame are seen,
  /// image u; infinite where too few frames show both.
  double apart_factor = std::numeric_limits<double>::infinity();
  double quick_apart_factor = std::numeric_limits<double>::infinity();
  /// Slow structure over what quicker noise explains, as variances: about 1 where the vehicle moves
  /// as the model says, 0 where the frames are too few to tell.
  double misfit = 0.0;
  double apart_misfit = 0.0;  ///< the same of how far apart they are seen
  /// By which the line through both lamps leaves the level for a camera that rolls by its mean,
  /// rad; none where no frame shows both.
  Uncertain tilt_rad;
  /// By how much that changes from the first to the last of these frames, rad.
  Uncertain tilt_change_rad;

  /// Lets the factors be at least `times` those of `problem`.
  void widen(double times, const GeometryProblem& problem);
};

/// `focal_px` turns normalised errors into pixels. Needs at least one observation.
ResidualCheck check_residuals(const GeometryProblem& problem, const PathVector& parameters,
                              double focal_px);

}  // namespace vildar
