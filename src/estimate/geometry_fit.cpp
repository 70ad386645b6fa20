#include "estimate/geometry_fit.h"

#include <cmath>

#include <ceres/ceres.h>

#include "estimate/geometry_cost.h"

namespace vildar {
void add_geometry(const GeometryProblem& problem, double* path, const std::vector<int>& free,
                  ceres::LossFunction* loss, ceres::LossFunction* apart_loss,
                  ceres::Problem& ceres_problem) {
  for (std::size_t i = 0; i < problem.lamps.size(); ++i) {
    ceres_problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<LampResidual, 2, kPathParameters>(
            new LampResidual{&problem, i}),
        loss, path);
    if (const auto shares = apart_shares(problem, i))
      ceres_problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<ApartResidual, 1, kPathParameters>(
              new ApartResidual{&problem, i, *shares}),
          apart_loss, path);
  }
  auto* priors = new PriorResidual{&problem};
  ceres_problem.AddResidualBlock(
      new ceres::AutoDiffCostFunction<PriorResidual, ceres::DYNAMIC, kPathParameters>(
          priors, priors->count()),
      nullptr, path);
  hold_fixed_all_but(free, kPathParameters, path, ceres_problem);
}

std::optional<ApartShares> apart_shares(const GeometryProblem& problem, std::size_t first) {
  if (first + 1 >= problem.lamps.size()) return std::nullopt;
  const LampObservation& one = problem.lamps[first];
  const LampObservation& other = problem.lamps[first + 1];
  if (one.sighting != other.sighting) return std::nullopt;
  constexpr double kWorth = 0.7;
  const double better = problem.sigma_factor.x() / problem.apart_factor;
  if (!(better * kWorth > 1.0)) return std::nullopt;
  const double share =
      std::sqrt(better * better - 1.0) / std::hypot(one.sigma.x(), other.sigma.x());
  return ApartShares{share * one.sigma.x(), -share * other.sigma.x()};
}

std::vector<int> free_parameters(const GeometryProblem& problem) {
  std::vector<int> free{kLogScale, kClosingRate, kAcceleration, kLateral, kDrop};
  if (problem.pairs) free.push_back(kLogSeparation);
  if (problem.setting.bend != 0.0) free.push_back(kLogRadius);
  if (problem.setting.straight_unsure) free.push_back(kStraight);
  for (int axis = 0; axis < 3; ++axis)
    if (problem.priors.turn_rad[static_cast<std::size_t>(axis)].std > 0.0)
      free.push_back(kYaw + axis);
  if (problem.priors.log_focal.std > 0.0) free.push_back(kLogFocal);
  for (int i = kHeading; i < kPathParameters; ++i)
    if (problem.ego_unknowns[static_cast<std::size_t>(i - kHeading)].std > 0.0) free.push_back(i);
  return free;
}

std::optional<double> geometry_cost(const GeometryProblem& problem, const PathVector& parameters) {
  const ceres::HuberLoss loss(kHuberBound), apart_loss(kApartBound);
  double cost = 0.0, before = 0.0;
  const auto add = [&](const ceres::HuberLoss& by, double square) {
    double rho[3];
    by.Evaluate(square, rho);
    cost += 0.5 * rho[0];
  };
  for (std::size_t i = 0; i < problem.lamps.size(); ++i) {
    Eigen::Vector2d residual;
    if (!LampResidual{&problem, i}(parameters.data(), residual.data())) return std::nullopt;
    add(loss, residual.squaredNorm());
    if (const auto shares = i > 0 ? apart_shares(problem, i - 1) : std::nullopt)
      add(apart_loss, std::pow(shares->first * before + shares->second * residual.x(), 2));
    before = residual.x();
  }
  const PriorResidual priors{&problem};
  Eigen::VectorXd residual(priors.count());
  priors(parameters.data(), residual.data());
  return cost + 0.5 * residual.squaredNorm();
}

Outcome<GeometryFit> fit_geometry(const GeometryProblem& problem, const PathVector& start) {
  constexpr double kTolerance = 3e-3;  // sigmas
  // Where no lengths like those known explain the bearings, ever shorter ones cost less: the priors
  // on them are bounded, and the rest becomes that of a toy.
  constexpr double kMostShrunkLn = 5.0, kShrunkLn = 4.0;
  const std::vector<int> free = free_parameters(problem);
  GeometryFit fit;
  fit.parameters = start;
  double reached = start[kLogScale];  // by steps that were taken
  const auto outcome = descend(
      [&](const Eigen::VectorXd& unknowns, bool with_slopes) -> std::optional<Residuals> {
        fit.parameters(free) = unknowns;
        if (fit.parameters[kLogScale] < start[kLogScale] - kMostShrunkLn) return std::nullopt;
        if (with_slopes) reached = fit.parameters[kLogScale];
        return geometry_residuals(problem, fit.parameters, free,
                                  with_slopes ? Slopes::of_path : Slopes::none);
      },
      start(free), kTolerance);
  if (const Miss* miss = std::get_if<Miss>(&outcome))
    return reached < start[kLogScale] - kShrunkLn ? Miss::bad_fit : *miss;
  const Minimum& minimum = std::get<Minimum>(outcome);
  const auto covariance = inverse_information(minimum.information);
  if (!covariance) return Miss::unobservable;
  fit.cost = minimum.cost;
  fit.parameters(free) = minimum.unknowns;
  fit.covariance(free, free) = *covariance;
  const PriorResidual priors{&problem};
  Eigen::VectorXd residual(priors.count());
  priors(fit.parameters.data(), residual.data());
  fit.prior_chi2 = residual.head(priors.metric_count()).squaredNorm();
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
