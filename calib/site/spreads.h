#pragma once

#include <optional>
#include <span>
#include <vector>

#include "calib/site/joint_solve.h"

namespace vildar {

/// Means of the populations, and what the passes lie off them.
struct Learned {
  Eigen::VectorXd means;
  Eigen::MatrixXd covariance;  ///< of the means
  /// Per pass, one per membership: expected squared distance of its value from the mean, and the
  /// variance that the value would have without the population.
  std::vector<Eigen::VectorXd> squares, own_variances;
};

/// Estimates the spreads of the populations from linearised passes and writes them to
/// `populations`: expectation-maximisation of the likelihood with passes and means integrated out,
/// each population's likely spread as a scaled inverse chi-square prior.
Learned learn_spreads(std::span<const LinearPass> passes, std::vector<Population>& populations);

/// Index of the pass that is most unlike all others, judged by the spreads that these show; nothing
/// where none is beyond chance.
std::optional<std::size_t> stranger(std::span<const LinearPass> passes, const Learned& learned,
                                    const std::vector<Population>& populations);

}  // namespace vildar
