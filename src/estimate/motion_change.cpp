#include "estimate/motion_change.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <ceres/jet.h>
#include <Eigen/Cholesky>

#include "estimate/geometry_cost.h"
#include "estimate/wander.h"

namespace vildar {
namespace {

using PathJet = ceres::Jet<double, kPathParameters>;

constexpr int kMostSteps = 16, kFewestSteps = 3, kFramesPerStep = 4;

std::vector<AccelerationStep> even_steps(const GeometryProblem& problem, int frames) {
  const int count = std::min(kMostSteps, frames / kFramesPerStep);
  std::vector<AccelerationStep> steps;
  if (count < kFewestSteps) return steps;
  const double from_s = problem.lamps.front().time_s - problem.reference_s;
  const double length_s = problem.lamps.back().time_s - problem.lamps.front().time_s;
  for (int i = 1; i <= count; ++i) steps.push_back({from_s + length_s * i / (count + 1), 0.0});
  return steps;
}

// Of all priors' residuals, which the sizes of the steps enter linearly, by each of these.
Eigen::MatrixXd prior_slopes(const GeometryProblem& problem, const PathVector& parameters) {
  const auto steps = static_cast<Eigen::Index>(problem.setting.steps.size());
  const Eigen::Index count = PriorResidual{&problem}.count();
  Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(count, steps);
  if (!problem.priors.motion) return slopes;
  GeometryProblem moved = problem;
  Eigen::VectorXd before(count), after(count);
  PriorResidual{&problem}(parameters.data(), before.data());
  for (Eigen::Index k = 0; k < steps; ++k) {
    double& size = moved.setting.steps[static_cast<std::size_t>(k)].size;
    size += 1.0;
    PriorResidual{&moved}(parameters.data(), after.data());
    size -= 1.0;
    slopes.col(k) = after - before;
  }
  return slopes;
}

// Normal equations of the path's free unknowns and of the sizes of the steps.
WanderNormal normal_equations(const GeometryProblem& problem, const PathVector& parameters,
                              const std::vector<int>& free) {
  const auto n = static_cast<Eigen::Index>(free.size());
  const std::vector<AccelerationStep>& steps = problem.setting.steps;
  const Eigen::Index size = n + static_cast<Eigen::Index>(steps.size());
  WanderNormal normal{Eigen::MatrixXd::Zero(size, size), Eigen::VectorXd::Zero(size)};
  const auto add = [&](const Eigen::VectorXd& by, double residual) {
    normal.information.selfadjointView<Eigen::Lower>().rankUpdate(by);
    normal.gradient += residual * by;
  };
  std::array<PathJet, kPathParameters> path;
  for (int i = 0; i < kPathParameters; ++i)
    path[static_cast<std::size_t>(i)] = PathJet(parameters[i], i);
  Eigen::VectorXd slopes(size);
  for (std::size_t i = 0; i < problem.lamps.size(); ++i) {
    std::array<PathJet, 2> residual;
    if (!LampResidual{&problem, i}(path.data(), residual.data())) continue;
    const double tau_s = problem.lamps[i].time_s - problem.reference_s;
    const double norm = std::hypot(residual[0].a, residual[1].a);
    const double weight = std::sqrt(std::min(1.0, kHuberBound / std::max(norm, 1e-12)));
    for (std::size_t axis = 0; axis < 2; ++axis) {
      for (Eigen::Index k = 0; k < n; ++k)
        slopes[k] = weight * residual[axis].v[free[static_cast<std::size_t>(k)]];
      // A step moves the vehicle as a closing rate would that has gone as far by then.
      const double by_rate = weight * residual[axis].v[kClosingRate];
      for (std::size_t k = 0; k < steps.size(); ++k) {
        const double moved = steps[k].way(tau_s);
        slopes[n + static_cast<Eigen::Index>(k)] = moved == 0.0 ? 0.0 : by_rate * moved / tau_s;
      }
      add(slopes, weight * residual[axis].a);
    }
  }
  const PriorResidual priors{&problem};
  std::vector<PathJet> residuals(static_cast<std::size_t>(priors.count()));
  priors(path.data(), residuals.data());
  const Eigen::MatrixXd by_size = prior_slopes(problem, parameters);
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    for (Eigen::Index k = 0; k < n; ++k)
      slopes[k] = residuals[i].v[free[static_cast<std::size_t>(k)]];
    slopes.tail(size - n) = by_size.row(static_cast<Eigen::Index>(i));
    add(slopes, residuals[i].a);
  }
  normal.information = Eigen::MatrixXd(normal.information.selfadjointView<Eigen::Lower>());
  return normal;
}

// Moves path and steps as far along `way` as what is seen, the priors and that on the steps
// (`precision`) agree to: the way is that of a tangent, which leads astray where little holds the
// pose. False, and the path not moved, where they do not agree to any of it.
bool go(GeometryProblem& problem, PathVector& parameters, const std::vector<int>& free,
        const Eigen::VectorXd& way, double precision) {
  constexpr double kSlack = 0.5;
  constexpr int kHalvings = 4;
  std::vector<AccelerationStep>& steps = problem.setting.steps;
  const auto cost = [&](const PathVector& at) {
    double prior = 0.0;
    for (const AccelerationStep& step : steps) prior += 0.5 * precision * step.size * step.size;
    const auto seen = geometry_cost(problem, at);
    return seen ? *seen + prior : INFINITY;
  };
  const double most = cost(parameters) + kSlack;
  const std::vector<AccelerationStep> before = steps;
  double share = 1.0;
  for (int halving = 0; halving <= kHalvings; ++halving, share *= 0.5) {
    PathVector moved = parameters;
    for (std::size_t k = 0; k < free.size(); ++k)
      moved[free[k]] += share * way[static_cast<Eigen::Index>(k)];
    for (std::size_t k = 0; k < steps.size(); ++k)
      steps[k].size = before[k].size + share * way[static_cast<Eigen::Index>(free.size() + k)];
    if (!(cost(moved) < most)) continue;
    parameters = moved;
    return true;
  }
  return false;
}

}  // namespace

double MotionChange::variance(const PathVector& by_path, const Eigen::VectorXd& by_size) const {
  if (by_size.size() == 0) return 0.0;
  const Eigen::VectorXd whole = by_size + response.transpose() * by_path;
  return whole.dot(covariance * whole);
}

std::optional<MotionChange> find_motion_change(GeometryProblem& given, GeometryFit& fit,
                                               int frames) {
  GeometryProblem problem = given;
  std::vector<AccelerationStep>& steps = problem.setting.steps;
  if (steps.empty()) steps = even_steps(problem, frames);
  if (steps.empty()) return std::nullopt;
  const std::vector<int> free = free_parameters(problem);
  const auto n = static_cast<Eigen::Index>(free.size());
  const auto count = static_cast<Eigen::Index>(steps.size());
  const WanderNormal normal = normal_equations(problem, fit.parameters, free);
  Eigen::VectorXd sizes(count);
  for (Eigen::Index k = 0; k < count; ++k) sizes[k] = steps[static_cast<std::size_t>(k)].size;
  const double between_s = steps.size() > 1 ? steps[1].tau_s - steps[0].tau_s : 1.0;
  const double scale_m = std::exp(fit.parameters[kLogScale]);

  Uncertain& prior_mps2 = problem.priors.acceleration_mps2;
  AccelerationPrior prior{Eigen::VectorXd::Zero(n + count),
                          scale_m * fit.parameters[kAcceleration] - prior_mps2.mean,
                          prior_mps2.std * prior_mps2.std};
  for (Eigen::Index k = 0; k < n; ++k) {
    const int parameter = free[static_cast<std::size_t>(k)];
    if (parameter == kLogScale) prior.slopes[k] = scale_m * fit.parameters[kAcceleration];
    if (parameter == kAcceleration) prior.slopes[k] = scale_m;
  }

  const auto mixture = mix_wanders(normal, prior, sizes, between_s, scale_m);
  if (!mixture) return std::nullopt;
  prior_mps2.std = std::sqrt(mixture->acceleration_variance);
  MotionChange change;
  change.covariance = mixture->covariance.bottomRightCorner(count, count);
  change.response = decltype(change.response)::Zero(kPathParameters, count);
  const Eigen::MatrixXd response = -normal.information.topLeftCorner(n, n).ldlt().solve(
      normal.information.topRightCorner(n, count));
  for (Eigen::Index k = 0; k < n; ++k)
    change.response.row(free[static_cast<std::size_t>(k)]) = response.row(k);
  if (!go(problem, fit.parameters, free, mixture->moved, mixture->precision)) return std::nullopt;
  given = std::move(problem);
  return change;
}

}  // namespace vildar
