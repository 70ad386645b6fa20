#pragma once

#include <optional>

#include <Eigen/Core>

#include "estimate/geometry_fit.h"

namespace vildar {

/// What is left open of the steps that a vehicle's acceleration takes in view
/// (PathSetting::steps): one entry per step.
struct MotionChange {
  Eigen::MatrixXd covariance;  ///< of their sizes
  /// How the path's unknowns follow them, per unit of size.
  Eigen::Matrix<double, kPathParameters, Eigen::Dynamic> response;

  /// Variance that the steps add to a quantity with these derivatives by the path's unknowns and
  /// by the sizes.
  double variance(const PathVector& by_path, const Eigen::VectorXd& by_size) const;
};

/// Fits path and steps together, far from where the path alone would go; the steps are taken to
/// wander by 2.5 m/s^2 over the root of a second. False, and both left as they were, where the
/// frames are too few or no minimum is reached.
bool fit_steps(GeometryProblem& problem, PathVector& path, int frames, Along along);

/// Half the sum of squares of the steps' sizes, each over the standard deviation that fit_steps()
/// takes it to have.
double cost_of_steps(const PathSetting& setting, double scale_m);

/// Lets the acceleration of a fitted vehicle wander, along the road, or across it (with speed and
/// acceleration across at the reference time) and somewhat along: puts steps into `problem`, moves
/// `fit` along and says what both leave open. How far it wanders is weighed by the evidence of the
/// bearings themselves, with the sigmas of `problem`. Steps that it has already are the start; its
/// prior on the acceleration widens with them. Nothing, and both left as they were, where the
/// frames are too few or no motion near `fit` explains them better.
std::optional<MotionChange> find_motion_change(GeometryProblem& problem, GeometryFit& fit,
                                               int frames, Along along = Along::road);

}  // namespace vildar
