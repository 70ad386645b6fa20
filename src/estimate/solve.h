#pragma once

#include <vector>

#include <ceres/problem.h>
#include <Eigen/Core>

#include "core/outcome.h"

namespace vildar {

/// Lets the optimiser move only `free` of a parameter block of `size`.
void hold_fixed_all_but(const std::vector<int>& free, int size, double* block,
                        ceres::Problem& problem);

/// Minimises without asking how well the unknowns are determined; false where no minimum was
/// reached. Counts the steps where asked to.
/// `tolerance` is the relative change of the cost at which it stops.
bool minimise(ceres::Problem& problem, int* iterations = nullptr, double tolerance = 1e-10);

struct Solution {
  double cost = 0.0;
  Eigen::MatrixXd covariance;  ///< of the free parameters, blocks in the order given
  int iterations = 0;
};

/// Minimises a small dense problem and inverts its information matrix (loss-corrected J^T J,
/// undamped) at the optimum. The problem's blocks hold the solution afterwards.
/// Misses: not_converged, unobservable (smallest eigenvalue of the scaled information below 1e-12).
Outcome<Solution> solve(ceres::Problem& problem, const std::vector<double*>& blocks,
                        double tolerance = 1e-10);

}  // namespace vildar
