#pragma once

#include <optional>
#include <span>
#include <vector>

#include "estimate/delay_model.h"

namespace vildar {

/// Times, from the reference, at which the acceleration of a vehicle may change: evenly over the
/// light.
std::vector<double> delay_steps_s(const DelayRows& rows);

/// A delay fit whose acceleration takes steps.
struct DelayMotion {
  Eigen::VectorXd value;        ///< all unknowns of the model
  std::vector<int> known;       ///< those that `covariance` is of: kLogDelay, kAlpha, what is free
                                ///< of kLogFarGain to kOrder, and the steps
  Eigen::MatrixXd covariance;   ///< by the blocks' own sigmas times the root of `noise_factor`
  Eigen::VectorXd doubt;        ///< what light as unlike as DelayRows::Row::doubt does to `known`
  double step_precision = 0.0;  ///< of the prior on a step
  double acceleration_variance = 1.0;  ///< of the prior at the reference
  double noise_factor = 1.0;  ///< of the variance, by which the blocks' own sigmas fall short
};

/// Lets the acceleration of a vehicle take the model's steps as far as the evidence of the light
/// asks for, starting from a fit with a constant one. Nothing where the unknowns are not
/// determined.
std::optional<DelayMotion> find_delay_motion(const DelayModel& model, const DelayRows& rows,
                                             std::span<const double> steps_s,
                                             const Eigen::VectorXd& constant);

}  // namespace vildar
