#pragma once

#include <optional>

#include <Eigen/Core>

namespace vildar {

/// Variance of an acceleration of which nothing is known beforehand.
inline constexpr double kAccelerationVariance_m2ps4 = 1.5 * 1.5;

/// Normal equations of a motion whose acceleration takes steps, without a prior on their sizes:
/// 0.5 x' information x + gradient' x + const. The sizes are the last unknowns.
struct WanderNormal {
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
};

/// The prior on the acceleration at the reference time that these hold: how far it is from the
/// prior's mean, the slopes of that by all unknowns, and the variance. It widens with the steps.
struct AccelerationPrior {
  Eigen::VectorXd slopes;
  double residual_mps2 = 0.0, variance = 1.0;
};

/// The same equations with another variance of that prior.
WanderNormal with_variance(const WanderNormal& normal, const AccelerationPrior& prior,
                           double variance);

/// Step, posterior covariance and priors, the mean over all ways of wandering.
struct WanderMixture {
  Eigen::VectorXd moved;
  Eigen::MatrixXd covariance;
  double acceleration_variance = 1.0;
  double precision = 0.0;  ///< of the prior on a size
};

/// How far the acceleration wanders (0.05 to 6 m/s^2 over the root of a second; most vehicles
/// cruise, a few brake hard) is weighed by the evidence. `sizes`: of the steps so far, in units of
/// `mps2_per_size`, `between_s` apart. Nothing where the equations do not determine the unknowns.
std::optional<WanderMixture> mix_wanders(const WanderNormal& normal, const AccelerationPrior& prior,
                                         const Eigen::VectorXd& sizes, double between_s,
                                         double mps2_per_size);

}  // namespace vildar
