#pragma once

#include <vector>

#include "estimate/joint_problem.h"

namespace vildar {

struct JointUnknowns {
  PathVector path;
  LightVector light{};
  std::vector<ReceiverVector> own;  ///< of each photodiode
};

struct JointSolution {
  JointUnknowns unknowns;
  /// Of path, light and each photodiode's own, one after the other; zero for those held fixed.
  Eigen::MatrixXd covariance;
  std::vector<Eigen::VectorXd> errors;  ///< of each photodiode's blocks, in power units
};

/// Where a photodiode's own unknowns begin in the covariance.
Eigen::Index first_own(std::size_t receiver);

/// All unknowns for a path; the light's are fitted to ln of the blocks that are clear of the noise,
/// which they enter all but linearly.
JointUnknowns start_of(const JointProblem& joint, const PathVector& path);

/// Least squares over path, light and each photodiode's own (Huber loss per lamp and per block).
/// Misses: not_converged, unobservable.
Outcome<JointSolution> solve_joint(const JointProblem& joint, const JointUnknowns& start);

}  // namespace vildar
