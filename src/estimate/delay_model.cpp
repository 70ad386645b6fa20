#include "estimate/delay_model.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace vildar {
namespace {

// Holds what no block reaches; next to nothing beside one block of data.
constexpr double kCoefficientStd = 1e3;

struct Term {
  int parameter;
  double slope;
};

}  // namespace

DelayModel::DelayModel(const DelayProblem& problem, const DelayRows& rows, CubicSpline curve)
    : problem_(problem), rows_(rows), curve_(std::move(curve)) {
  const auto scaled = [&](const Uncertain& level_w, std::size_t side) {
    constexpr double kLeastStd = 1e-9;
    ambient_[side] = level_w.mean / rows.unit_w;
    ambient_std_[side] = std::max(level_w.std / rows.unit_w, kLeastStd);
  };
  scaled(problem.near.ambient_w, 0);
  scaled(problem.far.ambient_w, 1);
}

Eigen::VectorXd DelayModel::start(double delay_s) const {
  Eigen::VectorXd value = Eigen::VectorXd::Zero(kDelayParameters + curve_.size());
  value[kLogDelay] = std::log(delay_s);
  value[kLogFarGain] = problem_.log_ratio.mean;
  value[kNearAmbient] = ambient_[0];
  value[kFarAmbient] = ambient_[1];
  return value;
}

std::vector<int> DelayModel::free(bool move_delay) const {
  std::vector<int> found{kNearAmbient, kFarAmbient};
  if (move_delay) {
    found.insert(found.end(), {kLogDelay, kAlpha});
    if (problem_.log_ratio.std > 0.0) found.insert(found.end(), {kLogFarGain, kAngularGain});
  }
  for (int k = 0; k < curve_.size(); ++k) found.push_back(kDelayParameters + k);
  return found;
}

DelayModel::Light DelayModel::light_of(const DelayRows::Row& row,
                                       const Eigen::VectorXd& value) const {
  const double delay_s = std::exp(value[kLogDelay]);
  Light found;
  found.by_log_delay =
      delay_s * ((row.far ? 1.0 : 0.0) + row.departed_m / problem_.baseline_m.mean);
  found.local = curve_.at(row.tau_s * (1.0 + 0.5 * value[kAlpha] * row.tau_s) + found.by_log_delay);
  if (row.far) found.gain = std::exp(value[kLogFarGain] + value[kAngularGain] * row.root);
  for (std::size_t k = 0; k < 4; ++k) {
    const double scaled =
        found.gain * value[kDelayParameters + found.local.first + static_cast<int>(k)];
    found.light += found.local.value[k] * scaled;
    found.slope += found.local.slope[k] * scaled;
  }
  return found;
}

// The curve is a function of the way driven, so the vehicle must not turn round.
bool DelayModel::drives_on(double alpha) const {
  constexpr double kSlowest = 0.05;  // of the speed at the reference
  return 1.0 + alpha * rows_.first_s > kSlowest && 1.0 + alpha * rows_.last_s > kSlowest;
}

DelayModel::Point DelayModel::at(const Eigen::VectorXd& value, bool with_derivatives) const {
  Point point;
  point.value = value;
  if (with_derivatives) {
    point.information = Eigen::MatrixXd::Zero(value.size(), value.size());
    point.gradient = Eigen::VectorXd::Zero(value.size());
  }
  for (const DelayRows::Row& row : rows_.rows) {
    const auto [local, by_log_delay, gain, light, slope] = light_of(row, value);
    const int ambient = row.far ? kFarAmbient : kNearAmbient;
    const double residual = (light + value[ambient] - row.power) / row.sigma;
    point.cost += 0.5 * residual * residual;
    if (!with_derivatives) continue;
    std::array<Term, 9> terms;
    std::size_t count = 0;
    for (std::size_t k = 0; k < 4; ++k)
      terms[count++] = {kDelayParameters + local.first + static_cast<int>(k),
                        gain * local.value[k]};
    terms[count++] = {ambient, 1.0};
    terms[count++] = {kAlpha, 0.5 * slope * row.tau_s * row.tau_s};
    terms[count++] = {kLogDelay, slope * by_log_delay};
    if (row.far) {
      terms[count++] = {kLogFarGain, light};
      terms[count++] = {kAngularGain, light * row.root};
    }
    for (std::size_t i = 0; i < count; ++i) {
      const double scaled = terms[i].slope / row.sigma;
      point.gradient[terms[i].parameter] += scaled * residual;
      for (std::size_t j = 0; j < count; ++j)
        point.information(terms[i].parameter, terms[j].parameter) +=
            scaled * terms[j].slope / row.sigma;
    }
  }
  add_priors(point, with_derivatives);
  return point;
}

void DelayModel::add_priors(Point& point, bool with_derivatives) const {
  const Eigen::VectorXd& value = point.value;
  const auto add = [&](int parameter, double apart, double std) {
    const double residual = apart / std;
    point.cost += 0.5 * residual * residual;
    if (!with_derivatives) return;
    point.gradient[parameter] += residual / std;
    point.information(parameter, parameter) += 1.0 / (std * std);
  };
  add(kNearAmbient, value[kNearAmbient] - ambient_[0], ambient_std_[0]);
  add(kFarAmbient, value[kFarAmbient] - ambient_[1], ambient_std_[1]);
  if (problem_.log_ratio.std > 0.0) {
    add(kLogFarGain, value[kLogFarGain] - problem_.log_ratio.mean, problem_.log_ratio.std);
    add(kAngularGain, value[kAngularGain], problem_.log_ratio.std);
  }
  for (int k = 0; k < curve_.size(); ++k)
    add(kDelayParameters + k, value[kDelayParameters + k], kCoefficientStd);

  const Uncertain& prior = problem_.acceleration.mps2;
  const double speed_mps = problem_.baseline_m.mean * std::exp(-value[kLogDelay]);
  const double residual = (value[kAlpha] * speed_mps - prior.mean) / prior.std;
  point.cost += 0.5 * residual * residual;
  if (!with_derivatives) return;
  const std::array<Term, 2> terms{Term{kAlpha, speed_mps / prior.std},
                                  Term{kLogDelay, -value[kAlpha] * speed_mps / prior.std}};
  for (const Term& one : terms) {
    point.gradient[one.parameter] += one.slope * residual;
    for (const Term& other : terms)
      point.information(one.parameter, other.parameter) += one.slope * other.slope;
  }
}

double DelayModel::prior_chi2(const Eigen::VectorXd& value) const {
  const Uncertain& acceleration_mps2 = problem_.acceleration.mps2;
  const double rate_mps2 = value[kAlpha] * problem_.baseline_m.mean * std::exp(-value[kLogDelay]);
  double sum = std::pow((rate_mps2 - acceleration_mps2.mean) / acceleration_mps2.std, 2);
  if (problem_.log_ratio.std > 0.0)
    sum += std::pow((value[kLogFarGain] - problem_.log_ratio.mean) / problem_.log_ratio.std, 2) +
           std::pow(value[kAngularGain] / problem_.log_ratio.std, 2);
  return sum;
}

DelayModel::Point DelayModel::minimise(Eigen::VectorXd value, bool move_delay,
                                       int most_iterations) const {
  constexpr double kEnough = 1e-4;  // of half a chi-square
  const std::vector<int> moved = free(move_delay);
  double damping = 1e-9;
  Point here = at(value, true);
  constexpr double kNoWayDown = 1e9;
  bool converged = false;
  for (int iteration = 0; iteration < most_iterations && !converged; ++iteration) {
    Eigen::MatrixXd system = here.information(moved, moved);
    system.diagonal() *= 1.0 + damping;
    const Eigen::VectorXd step = system.ldlt().solve(here.gradient(moved));
    Point there;
    there.value = here.value;
    there.value(moved) -= step;
    const bool allowed = there.value.allFinite() && drives_on(there.value[kAlpha]);
    if (allowed) there.cost = at(there.value, false).cost;
    if (!allowed || !(there.cost <= here.cost)) {
      damping = std::max(10.0 * damping, 1e-6);
      converged = damping > kNoWayDown;
      continue;
    }
    const double gained = here.cost - there.cost;
    here = at(there.value, true);
    damping = std::max(0.1 * damping, 1e-12);
    converged = gained < kEnough;
  }
  here.converged = converged;
  return here;
}

Eigen::VectorXd DelayModel::residuals(const Eigen::VectorXd& value) const {
  Eigen::VectorXd found(static_cast<Eigen::Index>(rows_.rows.size()));
  for (std::size_t i = 0; i < rows_.rows.size(); ++i) {
    const DelayRows::Row& row = rows_.rows[i];
    const double ambient = value[row.far ? kFarAmbient : kNearAmbient];
    found[static_cast<Eigen::Index>(i)] =
        (light_of(row, value).light + ambient - row.power) / row.sigma;
  }
  return found;
}

}  // namespace vildar
