#pragma once

#include <functional>
#include <limits>
#include <optional>
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

/// Inverse of an information matrix; nothing where its smallest eigenvalue, scaled to a unit
/// diagonal, is below 1e-12.
std::optional<Eigen::MatrixXd> inverse_information(const Eigen::MatrixXd& information);

/// Whitened residuals at one point as a robust loss weighs them: times the root of its slope.
struct Residuals {
  double cost = 0.0;  ///< half the sum of squares, after loss
  Eigen::VectorXd values;
  Eigen::MatrixXd slopes;  ///< one column for each residual, by the free unknowns

  Eigen::MatrixXd information() const { return slopes * slopes.transpose(); }
  Eigen::VectorXd gradient() const { return slopes * values; }
};

/// Nothing outside the model's domain; slopes only where asked for.
using ResidualsAt =
    std::function<std::optional<Residuals>(const Eigen::VectorXd& unknowns, bool with_slopes)>;

struct Minimum {
  Eigen::VectorXd unknowns;
  double cost = 0.0;
  Eigen::MatrixXd information;
  int iterations = 0;
};

/// How long a minimum is looked for.
struct Effort {
  int most_steps = 600;
  int hopeless_after = 40;  ///< steps
  double hopeless_cost = std::numeric_limits<double>::infinity();
};

/// Least squares for dense problems of few unknowns: Gauss-Newton steps, damped as by Levenberg and
/// Marquardt where they do not lower the cost; Newton's, with the cost's curvature by differences,
/// anew after four steps, where a dozen of these have not got there. Each is bent by what the
/// residuals' curvature asks for (Transtrum and Sethna 2012, geodesic acceleration). Stops where
/// the next step is shorter than `tolerance` sigmas or the last one gained no more than such a step
/// would. Misses: not_converged; bad_fit where the effort says that it is hopeless.
Outcome<Minimum> descend(const ResidualsAt& residuals, Eigen::VectorXd start, double tolerance,
                         const Effort& effort = {});

}  // namespace vildar
