#include <algorithm>
#include <array>
#include <cmath>

#include <ceres/jet.h>

#include "estimate/geometry_cost.h"

namespace vildar {
namespace {

using Eigen::Index;

// Of all priors' residuals, which the sizes of the steps enter linearly, by each of these.
Eigen::MatrixXd prior_slopes(const GeometryProblem& problem, const PathVector& parameters) {
  const auto steps = static_cast<Index>(problem.setting.steps.size());
  const Index count = PriorResidual{&problem}.count();
  Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(count, steps);
  GeometryProblem moved = problem;
  if (!moved.priors.motion) return slopes;
  Eigen::VectorXd before(count), after(count);
  PriorResidual{&moved}(parameters.data(), before.data());
  for (Index k = 0; k < steps; ++k) {
    double& size = moved.setting.steps[static_cast<std::size_t>(k)].size;
    size += 1.0;
    PriorResidual{&moved}(parameters.data(), after.data());
    size -= 1.0;
    slopes.col(k) = after - before;
  }
  return slopes;
}

// Slopes by at most `kMost` of the path's parameters: most of their cost goes with how many there
// are.
template <int kMost>
std::optional<Residuals> residuals_by(const GeometryProblem& problem, const PathVector& parameters,
                                      const std::vector<int>& free, Slopes slopes) {
  using Jet = ceres::Jet<double, kMost>;
  const PriorResidual priors{&problem};
  const Index lamps = 2 * static_cast<Index>(problem.lamps.size());
  Residuals found;
  found.values.resize(lamps + priors.count());
  const auto n = static_cast<Index>(free.size());
  const std::size_t steps = slopes == Slopes::of_path_and_steps ? problem.setting.steps.size() : 0;
  if (slopes != Slopes::none)
    found.slopes.resize(n + static_cast<Index>(steps), found.values.size());
  std::array<Jet, kPathParameters> path;
  for (int i = 0; i < kPathParameters; ++i) path[static_cast<std::size_t>(i)] = Jet(parameters[i]);
  for (Index k = 0; k < n; ++k)
    path[static_cast<std::size_t>(free[static_cast<std::size_t>(k)])].v[k] = 1.0;
  const auto rate = std::ranges::find(free, int{kClosingRate}) - free.begin();
  const auto lateral = std::ranges::find(free, int{kLateral}) - free.begin();
  double softened = 0.0;
  for (std::size_t i = 0; i < problem.lamps.size(); ++i) {
    const LampResidual lamp{&problem, i};
    std::array<Jet, 2> error;
    Eigen::Vector2d value;
    if (slopes == Slopes::none ? !lamp(parameters.data(), value.data())
                               : !lamp(path.data(), error.data()))
      return std::nullopt;
    if (slopes != Slopes::none) value = {error[0].a, error[1].a};
    const double norm = value.norm();
    const double weight = norm > kHuberBound ? std::sqrt(kHuberBound / norm) : 1.0;
    if (norm > kHuberBound) softened += 0.5 * kHuberBound * (norm - kHuberBound);
    const Index first = 2 * static_cast<Index>(i);
    found.values.segment<2>(first) = weight * value;
    if (slopes == Slopes::none) continue;
    const double tau_s = problem.lamps[i].time_s - problem.reference_s;
    Eigen::Vector2d by_turn = Eigen::Vector2d::Zero();  // of the line through the lamps
    if (problem.setting.crosses() && problem.lamps[i].side != 0.0)
      by_turn = weight * problem.lamps[i].side *
                std::exp(2.0 * parameters[kLogScale] + parameters[kLogSeparation]) /
                (std::exp(parameters[kLogScale]) *
                     (parameters[kClosingRate] + tau_s * parameters[kAcceleration]) -
                 problem.setting.own_mps) *
                lamp.by_x(parameters.data());
    for (std::size_t axis = 0; axis < 2; ++axis) {
      auto column = found.slopes.col(first + static_cast<Index>(axis));
      column.head(n) = weight * error[axis].v.head(n);
      // A step moves the vehicle as a closing rate would that has gone as far by then. Across the
      // road it turns the line through its lamps, too.
      const double by_way = tau_s != 0.0 ? weight * error[axis].v[rate] / tau_s : 0.0;
      const double by_lateral = weight * error[axis].v[lateral];
      for (std::size_t k = 0; k < steps; ++k) {
        const AccelerationStep& step = problem.setting.steps[k];
        column[n + static_cast<Index>(k)] =
            step.along == Along::across ? by_lateral * step.way(tau_s) +
                                              by_turn[static_cast<Index>(axis)] * step.rate(tau_s)
                                        : by_way * step.way(tau_s);
      }
    }
  }
  std::vector<Jet> errors(static_cast<std::size_t>(priors.count()));
  priors(path.data(), errors.data());
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const Index at = lamps + static_cast<Index>(i);
    found.values[at] = errors[i].a;
    if (slopes != Slopes::none) found.slopes.col(at).head(n) = errors[i].v.head(n);
  }
  if (steps > 0)
    found.slopes.bottomRightCorner(static_cast<Index>(steps), priors.count()) =
        prior_slopes(problem, parameters).transpose();
  found.cost = softened + 0.5 * found.values.squaredNorm();
  return found;
}

}  // namespace

std::optional<Residuals> geometry_residuals(const GeometryProblem& problem,
                                            const PathVector& parameters,
                                            const std::vector<int>& free, Slopes slopes) {
  constexpr int kSurveyedPair = 6, kTurnedPair = 11;
  if (free.size() <= kSurveyedPair)
    return residuals_by<kSurveyedPair>(problem, parameters, free, slopes);
  if (free.size() <= kTurnedPair)
    return residuals_by<kTurnedPair>(problem, parameters, free, slopes);
  return residuals_by<kPathParameters>(problem, parameters, free, slopes);
}

}  // namespace vildar
