#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <ceres/jet.h>

#include "core/quantity.h"
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

struct Apart {
  std::size_t first;  // lamp
  ApartShares shares;
};

std::vector<Apart> apart_of(const GeometryProblem& problem) {
  std::vector<Apart> found;
  for (std::size_t i = 0; i < problem.lamps.size(); ++i)
    if (const auto shares = apart_shares(problem, i)) found.push_back({i, *shares});
  return found;
}

// Weight of a residual by Huber's loss, and what half its square then lacks of that.
struct Softened {
  double weight = 1.0, lacks = 0.0;

  Softened(double norm, double bound) {
    if (norm <= bound) return;
    weight = std::sqrt(bound / norm);
    lacks = 0.5 * bound * (norm - bound);
  }
};

// Slopes by at most `kMost` of the path's parameters: most of their cost goes with how many there
// are.
template <int kMost>
std::optional<Residuals> residuals_by(const GeometryProblem& problem, const PathVector& parameters,
                                      const std::vector<int>& free, Slopes slopes) {
  using Jet = ceres::Jet<double, kMost>;
  const PriorResidual priors{&problem};
  const Index lamps = 2 * static_cast<Index>(problem.lamps.size());
  const std::vector<Apart> apart = apart_of(problem);
  const Index seen = lamps + static_cast<Index>(apart.size());
  Residuals found;
  found.values.resize(seen + priors.count());
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
  const double scale_m = std::exp(parameters[kLogScale]);
  double softened = 0.0;
  std::vector<double> weights;
  for (std::size_t i = 0; i < problem.lamps.size(); ++i) {
    const LampResidual lamp{&problem, i};
    std::array<Jet, 2> error;
    Eigen::Vector2d value;
    if (slopes == Slopes::none ? !lamp(parameters.data(), value.data())
                               : !lamp(path.data(), error.data()))
      return std::nullopt;
    if (slopes != Slopes::none) value = {error[0].a, error[1].a};
    const Softened soft(value.norm(), kHuberBound);
    const double weight = soft.weight;
    softened += soft.lacks;
    weights.push_back(weight);
    const Index first = 2 * static_cast<Index>(i);
    found.values.segment<2>(first) = weight * value;
    if (slopes == Slopes::none) continue;
    const double tau_s = problem.lamps[i].time_s - problem.reference_s;
    const bool crosses = steps > 0 && problem.setting.crosses();
    const bool on_bend = crosses && problem.setting.bend != 0.0;
    double turned_rad = 0.0, lane_share = 1.0;  // length of its lane over the first one's
    if (on_bend) {
      turned_rad = vehicle_point(parameters.data(), problem.setting, tau_s).heading_rad;
      lane_share -=
          problem.setting.bend * problem.setting.departed(tau_s, Along::across) /
          (std::exp(parameters[kLogRadius]) -
           problem.setting.bend * (problem.setting.camera_m.y() / scale_m + parameters[kLateral]));
    }
    Eigen::Matrix2d by_place = Eigen::Matrix2d::Zero();  // along its lane, and to the left
    if (crosses)
      by_place << lamp.by_place(parameters.data(), turned_rad),
          lamp.by_place(parameters.data(), turned_rad + 0.5 * kPi);
    // Of the line through the lamps: by the rate across, and by the one along, which turns it less.
    Eigen::Vector2d by_turn = Eigen::Vector2d::Zero(), by_rate = Eigen::Vector2d::Zero();
    if (crosses && problem.lamps[i].side != 0.0) {
      const double closing = parameters[kClosingRate] + tau_s * parameters[kAcceleration] +
                             problem.setting.departed_rate(tau_s);
      const double scaled = scale_m / (scale_m * closing - problem.setting.own_mps);
      const double left_per_ahead = scaled * problem.setting.departed_rate(tau_s, Along::across);
      by_turn =
          weight * problem.lamps[i].side * scaled * scale_m * std::exp(parameters[kLogSeparation]) *
          lamp.by_place(parameters.data(), on_bend ? turned_rad - left_per_ahead : turned_rad);
      by_rate = -left_per_ahead * by_turn;
    }
    for (std::size_t axis = 0; axis < 2; ++axis) {
      auto column = found.slopes.col(first + static_cast<Index>(axis));
      column.head(n) = weight * error[axis].v.head(n);
      // A step moves the vehicle as a closing rate would that has gone as far by then. Across the
      // road it turns the line through its lamps, too. On a bend rate and lateral offset do more.
      const auto at = static_cast<Index>(axis);
      const double by_way = on_bend        ? -weight * scale_m * lane_share * by_place(at, 0)
                            : tau_s != 0.0 ? (weight * error[axis].v[rate] - by_rate[at]) / tau_s
                                           : 0.0;
      const double by_lateral =
          weight * (on_bend ? scale_m * by_place(at, 1) : error[axis].v[lateral]);
      for (std::size_t k = 0; k < steps; ++k) {
        const AccelerationStep& step = problem.setting.steps[k];
        double& slope = column[n + static_cast<Index>(k)];
        if (step.along == Along::road) {
          slope = by_way * step.way(tau_s) + by_rate[at] * step.rate(tau_s);
          continue;
        }
        slope = by_lateral * step.way(tau_s) + by_turn[at] * step.rate(tau_s);
        if (on_bend)
          slope += by_way * gained_inside(parameters.data(), problem.setting, tau_s,
                                          [&](double at_s, double speed, double acceleration) {
                                            return step.swept(at_s, speed, acceleration);
                                          });
      }
    }
  }
  for (std::size_t i = 0; i < apart.size(); ++i) {
    const auto& [first, shares] = apart[i];
    const Index at = lamps + static_cast<Index>(i), one = 2 * static_cast<Index>(first);
    const double by_first = shares.first / weights[first],
                 by_second = shares.second / weights[first + 1];
    const double value = by_first * found.values[one] + by_second * found.values[one + 2];
    const Softened soft(std::abs(value), kApartBound);
    softened += soft.lacks;
    found.values[at] = soft.weight * value;
    if (slopes != Slopes::none)
      found.slopes.col(at) =
          soft.weight * (by_first * found.slopes.col(one) + by_second * found.slopes.col(one + 2));
  }
  std::vector<Jet> errors(static_cast<std::size_t>(priors.count()));
  priors(path.data(), errors.data());
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const Index at = seen + static_cast<Index>(i);
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
