#include "estimate/geometry_fit.h"

#include <ceres/ceres.h>

#include "estimate/geometry_cost.h"
#include "estimate/solve.h"

namespace vildar {
void add_geometry(const GeometryProblem& problem, double* path, const std::vector<int>& free,
                  ceres::LossFunction* loss, ceres::Problem& ceres_problem) {
  for (std::size_t i = 0; i < problem.lamps.size(); ++i)
    ceres_problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<LampResidual, 2, kPathParameters>(
            new LampResidual{&problem, i}),
        loss, path);
  auto* priors = new PriorResidual{&problem};
  ceres_problem.AddResidualBlock(
      new ceres::AutoDiffCostFunction<PriorResidual, ceres::DYNAMIC, kPathParameters>(
          priors, priors->count()),
      nullptr, path);
  hold_fixed_all_but(free, kPathParameters, path, ceres_problem);
}

std::vector<int> free_parameters(const GeometryProblem& problem) {
  std::vector<int> free{kLogScale, kClosingRate, kAcceleration, kLateral, kDrop};
  if (problem.pairs) free.push_back(kLogSeparation);
  if (problem.setting.bend != 0.0) free.push_back(kLogRadius);
  for (int axis = 0; axis < 3; ++axis)
    if (problem.priors.turn_rad[static_cast<std::size_t>(axis)].std > 0.0)
      free.push_back(kYaw + axis);
  return free;
}

std::optional<double> geometry_cost(const GeometryProblem& problem, const PathVector& parameters) {
  const ceres::HuberLoss loss(kHuberBound);
  double cost = 0.0;
  for (std::size_t i = 0; i < problem.lamps.size(); ++i) {
    Eigen::Vector2d residual;
    if (!LampResidual{&problem, i}(parameters.data(), residual.data())) return std::nullopt;
    double rho[3];
    loss.Evaluate(residual.squaredNorm(), rho);
    cost += 0.5 * rho[0];
  }
  const PriorResidual priors{&problem};
  Eigen::VectorXd residual(priors.count());
  priors(parameters.data(), residual.data());
  return cost + 0.5 * residual.squaredNorm();
}

Outcome<GeometryFit> fit_geometry(const GeometryProblem& problem, const PathVector& start) {
  if (!geometry_cost(problem, start)) return Miss::not_converged;
  GeometryFit fit;
  fit.parameters = start;
  ceres::HuberLoss loss(kHuberBound);
  ceres::Problem::Options options;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem ceres_problem(options);
  const std::vector<int> free = free_parameters(problem);
  add_geometry(problem, fit.parameters.data(), free, &loss, ceres_problem);
  const auto solved = solve(ceres_problem, {fit.parameters.data()});
  if (const Miss* miss = std::get_if<Miss>(&solved)) return *miss;
  const Solution& solution = std::get<Solution>(solved);
  fit.cost = solution.cost;
  for (std::size_t i = 0; i < free.size(); ++i)
    for (std::size_t j = 0; j < free.size(); ++j)
      fit.covariance(free[i], free[j]) =
          solution.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
  const PriorResidual priors{&problem};
  Eigen::VectorXd residual(priors.count());
  priors(fit.parameters.data(), residual.data());
  fit.prior_chi2 = residual.squaredNorm();
  return fit;
}

Eigen::Matrix2Xd bearing_residuals(const GeometryProblem& problem, const PathVector& parameters) {
  Eigen::Matrix2Xd residuals(2, static_cast<Eigen::Index>(problem.lamps.size()));
  for (std::size_t i = 0; i < problem.lamps.size(); ++i) {
    Eigen::Vector2d residual = Eigen::Vector2d::Zero();
    LampResidual{&problem, i}(parameters.data(), residual.data());
    residuals.col(static_cast<Eigen::Index>(i)) = residual.cwiseProduct(problem.sigma_factor);
  }
  return residuals;
}

}  // namespace vildar
