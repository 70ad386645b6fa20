#include "estimate/motion_change.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Cholesky>

#include "estimate/geometry_fit.h"
#include "estimate/wander.h"

namespace vildar {
namespace {

constexpr int kMostSteps = 16, kFewestSteps = 3, kFramesPerStep = 4;

std::vector<AccelerationStep> even_steps(const GeometryProblem& problem, int frames, Along along) {
  const int count = std::min(kMostSteps, frames / kFramesPerStep);
  std::vector<AccelerationStep> steps;
  if (count < kFewestSteps) return steps;
  const double from_s = problem.lamps.front().time_s - problem.reference_s;
  const double length_s = problem.lamps.back().time_s - problem.lamps.front().time_s;
  for (int i = 1; i <= count; ++i)
    steps.push_back({from_s + length_s * i / (count + 1), 0.0, along});
  if (along == Along::road) return steps;
  // Of how it crosses at the reference time the steps say nothing: it may be amid a lane change.
  // Along the road drivers who change lanes depart by less, and of that there is less to tell.
  constexpr double kAmid = 4.0, kAlongRoad = 0.3;
  for (const Departs departs : {Departs::by_speed, Departs::by_acceleration})
    steps.push_back({.along = along, .departs = departs, .unit = kAmid});
  for (int i = 1; i <= count / 2; ++i)
    steps.push_back({.tau_s = from_s + length_s * i / (count / 2 + 1), .unit = kAlongRoad});
  return steps;
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

namespace {

// Of the sizes of steps so far apart, over X.
double usual_size(const std::vector<AccelerationStep>& steps, double scale_m) {
  constexpr double kWander_mps2 = 2.5;  // over the root of a second
  return kWander_mps2 * std::sqrt(steps[1].tau_s - steps[0].tau_s) / scale_m;
}

}  // namespace

double cost_of_steps(const PathSetting& setting, double scale_m) {
  double sum = 0.0;
  for (const AccelerationStep& step : setting.steps) sum += 0.5 * step.size * step.size;
  return sum > 0.0 ? sum / std::pow(usual_size(setting.steps, scale_m), 2) : 0.0;
}

bool fit_steps(GeometryProblem& given, PathVector& fitted, int frames, Along along) {
  constexpr double kTolerance = 0.01;  // sigmas
  // Where a way across is none, what is left creeps down for minutes.
  constexpr int kMostTries = 60, kHopelessAfter = 12;
  constexpr double kHopeless = 25.0;  // cost of a lamp
  const Effort effort =
      along == Along::across
          ? Effort{kMostTries, kHopelessAfter, kHopeless * static_cast<double>(given.lamps.size())}
          : Effort{};
  GeometryProblem problem = given;
  std::vector<AccelerationStep>& steps = problem.setting.steps;
  steps = even_steps(problem, frames, along);
  if (steps.empty()) return false;
  const std::vector<int> free = free_parameters(problem);
  const auto n = static_cast<Eigen::Index>(free.size());
  const auto count = static_cast<Eigen::Index>(steps.size());
  const double size_std = usual_size(steps, std::exp(fitted[kLogScale]));
  PathVector path = fitted;
  const auto go_to = [&](const Eigen::VectorXd& unknowns) {
    path(free) = unknowns.head(n);
    for (Eigen::Index k = 0; k < count; ++k)
      steps[static_cast<std::size_t>(k)].size = size_std * unknowns[n + k];
  };
  Eigen::VectorXd start = Eigen::VectorXd::Zero(n + count);
  start.head(n) = path(free);
  const auto outcome = descend(
      [&](const Eigen::VectorXd& unknowns, bool with_slopes) -> std::optional<Residuals> {
        go_to(unknowns);
        auto found = geometry_residuals(problem, path, free,
                                        with_slopes ? Slopes::of_path_and_steps : Slopes::none);
        if (!found) return std::nullopt;
        const Eigen::Index seen = found->values.size();
        found->values.conservativeResize(seen + count);
        found->values.tail(count) = unknowns.tail(count);
        found->cost += 0.5 * unknowns.tail(count).squaredNorm();
        if (!with_slopes) return found;
        found->slopes.bottomRows(count) *= size_std;
        found->slopes.conservativeResize(n + count, seen + count);
        found->slopes.rightCols(count).setZero();
        found->slopes.bottomRightCorner(count, count).setIdentity();
        return found;
      },
      start, kTolerance, effort);
  const Minimum* minimum = std::get_if<Minimum>(&outcome);
  if (!minimum) return false;
  go_to(minimum->unknowns);
  fitted = path;
  given = std::move(problem);
  return true;
}

std::optional<MotionChange> find_motion_change(GeometryProblem& given, GeometryFit& fit, int frames,
                                               Along along) {
  GeometryProblem problem = given;
  std::vector<AccelerationStep>& steps = problem.setting.steps;
  if (steps.empty()) steps = even_steps(problem, frames, along);
  if (steps.empty()) return std::nullopt;
  const std::vector<int> free = free_parameters(problem);
  const auto n = static_cast<Eigen::Index>(free.size());
  const auto count = static_cast<Eigen::Index>(steps.size());
  const auto residuals =
      geometry_residuals(problem, fit.parameters, free, Slopes::of_path_and_steps);
  if (!residuals) return std::nullopt;
  const WanderNormal normal{residuals->information(), residuals->gradient()};
  Eigen::VectorXd sizes(count);
  for (Eigen::Index k = 0; k < count; ++k) sizes[k] = steps[static_cast<std::size_t>(k)].size;
  const double between_s = steps.size() > 1 ? steps[1].tau_s - steps[0].tau_s : 1.0;
  const double scale_m = std::exp(fit.parameters[kLogScale]);

  Uncertain& prior_mps2 = problem.priors.acceleration_mps2;
  AccelerationPrior prior{Eigen::VectorXd::Zero(n + count),
                          scale_m * fit.parameters[kAcceleration] - prior_mps2.mean,
                          prior_mps2.std * prior_mps2.std};
  if (along == Along::across) prior.residual_mps2 = 0.0;  // these leave it as it is
  for (Eigen::Index k = 0; k < n && along == Along::road; ++k) {
    const int parameter = free[static_cast<std::size_t>(k)];
    if (parameter == kLogScale) prior.slopes[k] = scale_m * fit.parameters[kAcceleration];
    if (parameter == kAcceleration) prior.slopes[k] = scale_m;
  }

  const auto mixture = mix_wanders(normal, prior, sizes, between_s, scale_m);
  if (!mixture) return std::nullopt;
  if (along == Along::road) prior_mps2.std = std::sqrt(mixture->acceleration_variance);
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
