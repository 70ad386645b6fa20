#include "estimate/solve.h"

#include <algorithm>
#include <cmath>

#include <ceres/ceres.h>
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace vildar {

void hold_fixed_all_but(const std::vector<int>& free, int size, double* block,
                        ceres::Problem& problem) {
  std::vector<int> fixed;
  for (int i = 0; i < size; ++i)
    if (std::find(free.begin(), free.end(), i) == free.end()) fixed.push_back(i);
  if (!fixed.empty()) problem.SetManifold(block, new ceres::SubsetManifold(size, fixed));
}

bool minimise(ceres::Problem& problem, int* iterations, double tolerance) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 200;
  options.function_tolerance = tolerance;
  options.parameter_tolerance = 1e-10;
  options.gradient_tolerance = 1e-12;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (iterations != nullptr) *iterations = static_cast<int>(summary.iterations.size());
  return summary.termination_type == ceres::CONVERGENCE;
}

Outcome<Solution> solve(ceres::Problem& problem, const std::vector<double*>& blocks,
                        double tolerance) {
  Solution solution;
  if (!minimise(problem, &solution.iterations, tolerance)) return Miss::not_converged;
  ceres::CRSMatrix sparse;
  ceres::Problem::EvaluateOptions evaluate;
  evaluate.parameter_blocks = blocks;
  problem.Evaluate(evaluate, &solution.cost, nullptr, nullptr, &sparse);
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(sparse.num_rows, sparse.num_cols);
  for (int row = 0; row < sparse.num_rows; ++row)
    for (int k = sparse.rows[static_cast<std::size_t>(row)];
         k < sparse.rows[static_cast<std::size_t>(row) + 1]; ++k)
      jacobian(row, sparse.cols[static_cast<std::size_t>(k)]) =
          sparse.values[static_cast<std::size_t>(k)];

  auto covariance = inverse_information(jacobian.transpose() * jacobian);
  if (!covariance) return Miss::unobservable;
  solution.covariance = std::move(*covariance);
  return solution;
}

std::optional<Eigen::MatrixXd> inverse_information(const Eigen::MatrixXd& information) {
  if (!(information.diagonal().minCoeff() > 0.0)) return std::nullopt;
  const Eigen::VectorXd scale = information.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scale.asDiagonal() * information *
                                                             scale.asDiagonal());
  constexpr double kSmallestEigenvalue = 1e-12;
  if (eigen.info() != Eigen::Success || !(eigen.eigenvalues().minCoeff() > kSmallestEigenvalue))
    return std::nullopt;
  const Eigen::MatrixXd root = scale.asDiagonal() * eigen.eigenvectors() *
                               eigen.eigenvalues().cwiseSqrt().cwiseInverse().asDiagonal();
  return root * root.transpose();
}

namespace {

// Of the cost, by differences of its gradient; the information where these leave the domain.
Eigen::MatrixXd curvature(const ResidualsAt& residuals, const Minimum& at,
                          const Eigen::VectorXd& gradient) {
  constexpr double kStep = 1e-3;   // sigmas
  constexpr double kLeast = 1e-8;  // of the unknown: less is lost in rounding
  const Eigen::VectorXd steps = (kStep * at.information.diagonal().cwiseSqrt().cwiseInverse())
                                    .cwiseMax(kLeast * at.unknowns.cwiseAbs());
  Eigen::MatrixXd hessian(steps.size(), steps.size());
  for (Eigen::Index k = 0; k < steps.size(); ++k) {
    Eigen::VectorXd moved = at.unknowns;
    moved[k] += steps[k];
    const auto there = residuals(moved, true);
    if (!there) return at.information;
    hessian.col(k) = (there->gradient() - gradient) / steps[k];
  }
  return 0.5 * (hessian + hessian.transpose());
}

}  // namespace

Outcome<Minimum> descend(const ResidualsAt& residuals, Eigen::VectorXd start, double tolerance,
                         const Effort& effort) {
  // Residuals that are many sigmas large and bend make Gauss-Newton creep, or go to and fro.
  constexpr int kQuickIterations = 12, kStepsBetween = 4;
  constexpr double kFirstDamping = 1e-6, kMostDamping = 1e12;
  constexpr double kRounding = 1e-13;  // of the cost
  const double least_gain = 0.5 * tolerance * tolerance;
  const auto cost_at = [&](const Eigen::VectorXd& unknowns) {
    const auto there = residuals(unknowns, false);
    return there ? there->cost : std::numeric_limits<double>::infinity();
  };
  auto here = residuals(start, true);
  if (!here) return Miss::not_converged;
  Minimum best{std::move(start), here->cost, here->information(), 0};
  double damping = 0.0;
  // What the residuals' bends add to the information, at `best` or so many steps before.
  std::optional<Eigen::MatrixXd> bends;
  int steps_since = 0;
  for (; best.iterations < effort.most_steps && damping < kMostDamping; ++best.iterations) {
    if (best.iterations >= effort.hopeless_after && best.cost > effort.hopeless_cost)
      return Miss::bad_fit;
    // Scaled to a unit diagonal: unknowns differ by many orders.
    const Eigen::VectorXd scale = best.information.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::VectorXd gradient = here->gradient();
    const bool quick = best.iterations < kQuickIterations;
    if (!quick && !bends) {
      bends = curvature(residuals, best, gradient) - best.information;
      steps_since = 0;
    }
    Eigen::MatrixXd damped = best.information;
    if (!quick) damped += *bends;
    damped = (scale.asDiagonal() * damped * scale.asDiagonal()).eval();
    damped.diagonal().array() += damping;
    const Eigen::LDLT<Eigen::MatrixXd> solver(damped);
    const auto step_by = [&](const Eigen::VectorXd& slope) -> Eigen::VectorXd {
      return -(scale.asDiagonal() * solver.solve(scale.cwiseProduct(slope)));
    };
    const Eigen::VectorXd step = step_by(gradient);
    const double decrement = -step.dot(gradient);
    if (step.allFinite() && (quick ? decrement >= 0.0 : solver.isPositive())) {
      if (0.5 * decrement < least_gain && damping == 0.0) return best;
      Eigen::VectorXd next = best.unknowns + step;
      if (const auto straight = residuals(next, false)) {
        const Eigen::VectorXd bent =
            next + step_by(here->slopes * straight->values - gradient - best.information * step);
        if (quick || cost_at(bent) < straight->cost) next = bent;
      }
      auto there = residuals(next, true);
      if (there && there->cost <= best.cost) {
        const double gain = best.cost - there->cost;
        here = std::move(there);
        best.unknowns = std::move(next);
        best.cost = here->cost;
        best.information = here->information();
        // A step by bends of before may gain little for that.
        const bool stale = bends && steps_since > 0;
        if (gain < least_gain && !stale) return best;
        if (bends && (gain < least_gain || ++steps_since >= kStepsBetween)) bends.reset();
        damping = damping > kFirstDamping ? 0.1 * damping : 0.0;
        continue;
      }
      // At the rounding floor no step gains any more.
      if (decrement < kRounding * best.cost) return best;
    }
    if (bends && steps_since > 0) {
      bends.reset();
      continue;
    }
    damping = damping > 0.0 ? 10.0 * damping : kFirstDamping;
  }
  return Miss::not_converged;
}

}  // namespace vildar
