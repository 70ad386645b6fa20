#include "estimate/speed_budget.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include <ceres/jet.h>
#include <Eigen/LU>

#include "estimate/geometry_cost.h"

namespace vildar {
namespace {

// Names of the prior residuals, in their order; what has none is not metric.
std::vector<std::string> prior_names(const GeometryProblem& problem) {
  const MetricPriors& priors = problem.priors;
  std::vector<std::string> names;
  if (priors.drop_m) names.push_back("lamp_height");
  if (problem.pairs && priors.separation_m) names.push_back("lamp_separation");
  if (priors.lateral_m) names.push_back("lane");
  if (problem.setting.bend != 0.0 && priors.radius_m) names.push_back("radius");
  if (priors.straight_m) names.push_back("straight");
  names.push_back("acceleration");
  if (priors.motion) names.insert(names.end(), 2, "photodiode_delay");
  const auto count = static_cast<std::size_t>(PriorResidual{&problem}.count());
  assert(names.size() <= count);
  names.resize(count);
  return names;
}

// Information on ln scale that each prior brings, all ratios held.
std::map<std::string, double> scale_information(const Trajectory& trajectory) {
  using Jet = ceres::Jet<double, 1>;
  const PriorResidual priors{&trajectory.problem};
  std::array<Jet, kPathParameters> path;
  for (int i = 0; i < kPathParameters; ++i)
    path[static_cast<std::size_t>(i)] = Jet(trajectory.fit.parameters[i]);
  path[kLogScale].v[0] = 1.0;
  std::vector<Jet> residuals(static_cast<std::size_t>(priors.count()));
  priors(path.data(), residuals.data());
  std::map<std::string, double> information;
  const std::vector<std::string> names = prior_names(trajectory.problem);
  for (std::size_t i = 0; i < names.size(); ++i)
    if (!names[i].empty()) information[names[i]] += residuals[i].v[0] * residuals[i].v[0];
  return information;
}

// The prior's residual has a variance of 1 less the share of it that the fit takes up. Of the
// camera's height over the lamps and of the closing motion the signs are turned to those of the
// lamps' height and of `acceleration_mps2`.
std::map<std::string, double> prior_pulls(const Trajectory& trajectory, bool recedes) {
  constexpr double kUntested = 0.1;  // of the variance
  using Jet = ceres::Jet<double, kPathParameters>;
  const PriorResidual priors{&trajectory.problem};
  std::array<Jet, kPathParameters> path;
  for (int i = 0; i < kPathParameters; ++i)
    path[static_cast<std::size_t>(i)] = Jet(trajectory.fit.parameters[i], i);
  std::vector<Jet> residuals(static_cast<std::size_t>(priors.count()));
  priors(path.data(), residuals.data());
  std::map<std::string, double> pulls;
  const std::vector<std::string> names = prior_names(trajectory.problem);
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i].empty() || names[i] == "photodiode_delay") continue;
    const PathVector& slopes = residuals[i].v;
    const double left_open = 1.0 - slopes.dot(trajectory.fit.covariance * slopes);
    if (left_open <= kUntested) continue;
    const bool turned = names[i] == "lamp_height" || (names[i] == "acceleration" && recedes);
    pulls[names[i]] = (turned ? -1.0 : 1.0) * residuals[i].a / std::sqrt(left_open);
  }
  return pulls;
}

}  // namespace

SpeedBudget speed_budget(const Trajectory& trajectory, double time_s) {
  const std::vector<int> free = free_parameters(trajectory.problem);
  const Eigen::MatrixXd covariance = trajectory.fit.covariance(free, free);
  const Eigen::VectorXd sigmas = covariance.diagonal().cwiseSqrt();
  const Eigen::MatrixXd correlation =
      sigmas.cwiseInverse().asDiagonal() * covariance * sigmas.cwiseInverse().asDiagonal();
  // ln scale is the first of the free parameters. Its information with all ratios held is what the
  // scale adds to the speed, whatever the shape does.
  const double held = correlation.inverse()(0, 0) / (sigmas[0] * sigmas[0]);
  const MotionState state = trajectory.at(time_s);
  const double relative = state.speed_std_mps / std::abs(state.over_ground_mps);
  SpeedBudget budget;
  const double scaled = std::abs(state.scaled_mps / state.over_ground_mps);
  budget.scale = std::min(relative, scaled / std::sqrt(held));
  budget.shape = std::sqrt(relative * relative - budget.scale * budget.scale);
  const auto information = scale_information(trajectory);
  double known = 0.0;
  for (const auto& [name, share] : information) known += share;
  const double whole = std::max(held, known);
  constexpr double kWorthNaming = 0.005;
  for (const auto& [name, share] : information)
    if (share > kWorthNaming * whole) budget.scale_shares[name] = share / whole;
  if (whole - known > kWorthNaming * whole) budget.scale_shares["other"] = (whole - known) / whole;
  budget.prior_pulls = prior_pulls(trajectory, state.over_ground_mps < 0.0);
  return budget;
}

double bearing_chi2_per_dof(const Trajectory& trajectory) {
  const Eigen::Matrix2Xd residuals =
      bearing_residuals(trajectory.problem, trajectory.fit.parameters);
  // The scale alone is not determined by the bearings.
  const double unknowns = static_cast<double>(free_parameters(trajectory.problem).size()) - 1.0;
  return residuals.squaredNorm() / std::max(1.0, static_cast<double>(residuals.size()) - unknowns);
}

}  // namespace vildar
