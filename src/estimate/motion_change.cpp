#include "estimate/motion_change.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <ceres/jet.h>
#include <Eigen/Cholesky>

#include "estimate/geometry_cost.h"

namespace vildar {
namespace {

using PathJet = ceres::Jet<double, kPathParameters>;

constexpr int kMostSteps = 16, kFewestSteps = 3, kFramesPerStep = 4;
constexpr double kBefore_s = 1.0;

// How far accelerations wander, in m/s^2 over the root of a second, and how many vehicles in a
// hundred are taken to do so: most cruise, a few brake hard.
struct Wander {
  double mps2_per_root_s, share;
};
constexpr std::array<Wander, 5> kWanders{
    {{0.05, 0.4}, {0.4, 0.25}, {1.0, 0.2}, {2.5, 0.1}, {6.0, 0.05}}};

std::vector<AccelerationStep> even_steps(const GeometryProblem& problem, int frames) {
  const int count = std::min(kMostSteps, frames / kFramesPerStep);
  std::vector<AccelerationStep> steps;
  if (count < kFewestSteps) return steps;
  const double from_s = problem.lamps.front().time_s - problem.reference_s;
  const double length_s = problem.lamps.back().time_s - problem.lamps.front().time_s;
  for (int i = 1; i <= count; ++i) steps.push_back({from_s + length_s * i / (count + 1), 0.0});
  return steps;
}

// Normal equations of the path's free unknowns and of the sizes of the steps, without a prior on
// the latter: 0.5 x' information x + gradient' x + const.
struct Normal {
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;

  void add(const Eigen::VectorXd& slopes, double residual) {
    information.selfadjointView<Eigen::Lower>().rankUpdate(slopes);
    gradient += residual * slopes;
  }
};

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

Normal normal_equations(const GeometryProblem& problem, const PathVector& parameters,
                        const std::vector<int>& free) {
  const auto n = static_cast<Eigen::Index>(free.size());
  const std::vector<AccelerationStep>& steps = problem.setting.steps;
  const Eigen::Index size = n + static_cast<Eigen::Index>(steps.size());
  Normal normal{Eigen::MatrixXd::Zero(size, size), Eigen::VectorXd::Zero(size)};
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
      normal.add(slopes, weight * residual[axis].a);
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
    normal.add(slopes, residuals[i].a);
  }
  normal.information = Eigen::MatrixXd(normal.information.selfadjointView<Eigen::Lower>());
  return normal;
}

// The unknowns for one way of wandering, and ln of its evidence up to what all have in common.
struct Posterior {
  Eigen::VectorXd moved;
  Eigen::MatrixXd covariance;
  double log_evidence = -INFINITY;
};

// What a fit takes for granted of the acceleration at the reference time: its residual in metres,
// the slope of that, and the variance.
struct AccelerationPrior {
  Eigen::VectorXd slopes;
  double residual_mps2 = 0.0, variance = 1.0;

  // The same prior with another variance.
  void replace(Normal& normal, double other) const {
    const double more = 1.0 / other - 1.0 / variance;
    normal.information += more * slopes * slopes.transpose();
    normal.gradient += more * residual_mps2 * slopes;
  }
  double log_density(double other) const {
    return -0.5 * (residual_mps2 * residual_mps2 / other + std::log(other));
  }
};

Posterior posterior_of(const Normal& normal, const Eigen::VectorXd& sizes, double size_std) {
  const Eigen::Index steps = sizes.size();
  Eigen::MatrixXd information = normal.information;
  Eigen::VectorXd gradient = normal.gradient;
  const double prior = 1.0 / (size_std * size_std);
  information.diagonal().tail(steps).array() += prior;
  gradient.tail(steps) += prior * sizes;
  // Scaled, for the unknowns differ by many powers of ten.
  const Eigen::VectorXd scale = information.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LLT<Eigen::MatrixXd> root(scale.asDiagonal() * information * scale.asDiagonal());
  Posterior posterior;
  if (root.info() != Eigen::Success) return posterior;
  posterior.covariance = scale.asDiagonal() *
                         root.solve(Eigen::MatrixXd::Identity(scale.size(), scale.size())) *
                         scale.asDiagonal();
  posterior.moved = -posterior.covariance * gradient;
  posterior.log_evidence = -0.5 * (prior * sizes.squaredNorm() + gradient.dot(posterior.moved)) -
                           root.matrixLLT().diagonal().array().log().sum() +
                           scale.array().log().sum() -
                           static_cast<double>(steps) * std::log(size_std);
  return posterior;
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
  const Normal normal = normal_equations(problem, fit.parameters, free);
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

  std::array<Posterior, kWanders.size()> posteriors;
  std::array<double, kWanders.size()> variances{}, size_stds{};
  double most = -INFINITY;
  for (std::size_t i = 0; i < kWanders.size(); ++i) {
    size_stds[i] = kWanders[i].mps2_per_root_s * std::sqrt(between_s) / scale_m;
    // It wandered as much before, too.
    variances[i] = std::pow(MetricPriors{}.acceleration_mps2.std, 2) +
                   std::pow(kWanders[i].mps2_per_root_s, 2) * kBefore_s;
    Normal wandering = normal;
    prior.replace(wandering, variances[i]);
    posteriors[i] = posterior_of(wandering, sizes, size_stds[i]);
    posteriors[i].log_evidence += std::log(kWanders[i].share) + prior.log_density(variances[i]);
    most = std::max(most, posteriors[i].log_evidence);
  }
  if (!std::isfinite(most)) return std::nullopt;
  double sum = 0.0, variance = 0.0, precision = 0.0;
  Eigen::VectorXd moved = Eigen::VectorXd::Zero(n + count);
  Eigen::MatrixXd square = Eigen::MatrixXd::Zero(count, count);
  for (std::size_t i = 0; i < posteriors.size(); ++i) {
    const Posterior& one = posteriors[i];
    const double weight = std::exp(one.log_evidence - most);
    if (!(weight > 0.0)) continue;
    sum += weight;
    variance += weight * variances[i];
    precision += weight / std::pow(size_stds[i], 2);
    moved += weight * one.moved;
    const Eigen::VectorXd size = one.moved.tail(count);
    square += weight * (one.covariance.bottomRightCorner(count, count) + size * size.transpose());
  }
  moved /= sum;
  prior_mps2.std = std::sqrt(variance / sum);
  MotionChange change;
  change.covariance = square / sum - moved.tail(count) * moved.tail(count).transpose();
  change.response = decltype(change.response)::Zero(kPathParameters, count);
  const Eigen::MatrixXd response = -normal.information.topLeftCorner(n, n).ldlt().solve(
      normal.information.topRightCorner(n, count));
  for (Eigen::Index k = 0; k < n; ++k)
    change.response.row(free[static_cast<std::size_t>(k)]) = response.row(k);
  if (!go(problem, fit.parameters, free, moved, precision / sum)) return std::nullopt;
  given = std::move(problem);
  return change;
}

}  // namespace vildar
