#pragma once

#include <span>
#include <vector>

#include "calib/site/populations.h"

namespace vildar {

/// Moves all trajectories and the means of the populations (`present`) to the minimum of their
/// joint least-squares problem, spreads held. Each pass is a block of its own, eliminated first
/// (Schur complement). False where the solver failed.
bool solve_jointly(std::span<Pass> passes, std::vector<Population>& populations);

/// What a pass says near its present path: information and gradient of its own residuals (robust),
/// and how its shared quantities follow the path. In the pass's free parameters.
struct LinearPass {
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
  Eigen::MatrixXd shared_by_path;  ///< one row per membership
  Eigen::VectorXd shared;          ///< present values
  std::vector<Membership> members;
};
LinearPass linearise(const Pass& pass, const std::vector<Population>& populations);

}  // namespace vildar
