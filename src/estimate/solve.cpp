#include "estimate/solve.h"

#include <algorithm>

#include <ceres/ceres.h>
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

  const Eigen::VectorXd norms = jacobian.colwise().norm();
  if (!(norms.minCoeff() > 0.0)) return Miss::unobservable;
  const Eigen::VectorXd inverse_norms = norms.cwiseInverse();
  const Eigen::MatrixXd scaled = jacobian * inverse_norms.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled.transpose() * scaled);
  constexpr double kSmallestEigenvalue = 1e-12;
  if (eigen.info() != Eigen::Success || !(eigen.eigenvalues().minCoeff() > kSmallestEigenvalue))
    return Miss::unobservable;
  const Eigen::MatrixXd root = inverse_norms.asDiagonal() * eigen.eigenvectors() *
                               eigen.eigenvalues().cwiseSqrt().cwiseInverse().asDiagonal();
  solution.covariance = root * root.transpose();
  return solution;
}

}  // namespace vildar
