#include "estimate/delay_model.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "estimate/wander.h"

namespace vildar {
namespace {

// Holds what no block reaches; next to nothing beside one block of data.
constexpr double kCoefficientStd = 1e3;
constexpr double kCommonStd = 1.0;  // of the brightest light
const double kAccelerationStd_mps2 = std::sqrt(kAccelerationVariance_m2ps4);

}  // namespace

double CommonLight::share(double at_tau_s) const {
  const auto [from_s, to_s] = between_s();
  if (at_tau_s < from_s || at_tau_s > to_s) return at_tau_s < tau_s ? 0.0 : 1.0;
  return 0.5 * std::erfc((tau_s - at_tau_s) / width_s);
}

DelayModel::DelayModel(const DelayProblem& problem, const DelayRows& rows, CubicSpline curve,
                       std::vector<double> steps_s)
    : problem_(problem), rows_(rows), curve_(std::move(curve)) {
  for (const double tau_s : steps_s) steps_.push_back({tau_s, 1.0});
  const auto scaled = [&](const Uncertain& level_w, std::size_t side) {
    constexpr double kLeastStd = 1e-9;
    ambient_[side] = level_w.mean / rows.unit_w;
    ambient_std_[side] = std::max(level_w.std / rows.unit_w, kLeastStd);
  };
  scaled(problem.near.ambient_w, 0);
  scaled(problem.far.ambient_w, 1);
}

Eigen::VectorXd DelayModel::start(double delay_s) const {
  Eigen::VectorXd value =
      Eigen::VectorXd::Zero(first_step() + static_cast<Eigen::Index>(steps_.size()));
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
    if (problem_.log_ratio.std > 0.0) found.push_back(kLogFarGain);
    if (finds_mismatch()) found.insert(found.end(), {kMismatch, kBend, kOrder});
  }
  for (int k = kDelayParameters; k < first_step(); ++k) found.push_back(k);
  return found;
}

bool DelayModel::finds_mismatch() const {
  return std::ranges::any_of(rows_.rows,
                             [](const DelayRows::Row& row) { return row.mismatch > 0.0; });
}

double DelayModel::way_s(const DelayRows::Row& row, const Eigen::VectorXd& value) const {
  return row.tau_s * (1.0 + 0.5 * value[kAlpha] * row.tau_s) + by_log_delay(row, value);
}

double DelayModel::by_log_delay(const DelayRows::Row& row, const Eigen::VectorXd& value) const {
  double departed_m = 0.0;
  for (std::size_t k = 0; k < steps_.size(); ++k)
    departed_m += value[first_step() + static_cast<int>(k)] * steps_[k].way(row.tau_s);
  return std::exp(value[kLogDelay]) *
         ((row.far ? 1.0 : 0.0) + departed_m / problem_.pose.baseline_m.mean);
}

double DelayModel::other_light(const DelayRows::Row& row, const Eigen::VectorXd& value) const {
  return value[row.far ? kFarAmbient : kNearAmbient] + common_light(row, value);
}

std::vector<std::array<double, 2>> DelayModel::common_powers(const Eigen::VectorXd& value) const {
  std::vector<std::array<double, 2>> powers;
  for (int k = first_common(); k < first_step(); k += 2) powers.push_back({value[k], value[k + 1]});
  return powers;
}

double DelayModel::common_light(const DelayRows::Row& row, const Eigen::VectorXd& value) const {
  double level = 0.0;
  for (std::size_t k = 0; k < rows_.common.size(); ++k)
    level += rows_.common[k].share(row.tau_s) *
             value[first_common() + 2 * static_cast<int>(k) + (row.far ? 1 : 0)];
  return level;
}

DelayModel::Light DelayModel::light_of(const DelayRows::Row& row,
                                       const Eigen::VectorXd& value) const {
  Light found;
  found.by_log_delay = by_log_delay(row, value);
  found.local = curve_.at(row.tau_s * (1.0 + 0.5 * value[kAlpha] * row.tau_s) + found.by_log_delay);
  if (row.far)
    found.gain = std::exp(value[kLogFarGain] + value[kMismatch] * row.mismatch +
                          value[kBend] * row.bend + value[kOrder] * row.order);
  for (std::size_t k = 0; k < 4; ++k) {
    const double scaled =
        found.gain * value[kDelayParameters + found.local.first + static_cast<int>(k)];
    found.light += found.local.value[k] * scaled;
    found.slope += found.local.slope[k] * scaled;
  }
  return found;
}

bool DelayModel::drives_on(const Eigen::VectorXd& value) const {
  constexpr double kSlowest = 0.05;  // of the speed at the reference
  const double per_mps = std::exp(value[kLogDelay]) / problem_.pose.baseline_m.mean;
  const auto share = [&](double tau_s) {
    double speed = 1.0 + value[kAlpha] * tau_s;
    for (std::size_t k = 0; k < steps_.size(); ++k)
      speed += per_mps * value[first_step() + static_cast<int>(k)] * steps_[k].beyond_s(tau_s);
    return speed;
  };
  // Between the steps the speed is a straight line.
  return share(rows_.first_s) > kSlowest && share(rows_.last_s) > kSlowest &&
         std::all_of(steps_.begin(), steps_.end(),
                     [&](const AccelerationStep& step) { return share(step.tau_s) > kSlowest; });
}

DelayModel::Motion DelayModel::motion_at(const Eigen::VectorXd& value, double tau_s) const {
  const double reference_mps = problem_.pose.baseline_m.mean * std::exp(-value[kLogDelay]);
  const double alpha = value[kAlpha];
  Motion motion{reference_mps * (1.0 + alpha * tau_s), reference_mps * alpha,
                Eigen::VectorXd::Zero(value.size()), Eigen::VectorXd::Zero(value.size())};
  motion.speed_slopes[kLogDelay] = -motion.speed_mps;
  motion.speed_slopes[kAlpha] = reference_mps * tau_s;
  motion.acceleration_slopes[kLogDelay] = -motion.acceleration_mps2;
  motion.acceleration_slopes[kAlpha] = reference_mps;
  for (std::size_t k = 0; k < steps_.size(); ++k) {
    const int parameter = first_step() + static_cast<int>(k);
    const double beyond_s = steps_[k].beyond_s(tau_s);
    motion.speed_slopes[parameter] = beyond_s;
    motion.speed_mps += beyond_s * value[parameter];
    if (beyond_s == 0.0) continue;
    motion.acceleration_slopes[parameter] = 1.0;
    motion.acceleration_mps2 += value[parameter];
  }
  return motion;
}

void DelayModel::put_line(const DelayRows::Row& row, const Eigen::VectorXd& value, Line& line,
                          Slopes slopes) const {
  const double per_mps = std::exp(value[kLogDelay]) / problem_.pose.baseline_m.mean;
  const auto [local, by_log_delay, gain, light, slope] = light_of(row, value);
  line.light = light;
  line.beyond = light + other_light(row, value) - row.power;
  std::vector<Term>& terms = line.terms;
  terms.clear();
  for (std::size_t k = 0; k < 4; ++k)
    terms.push_back({kDelayParameters + local.first + static_cast<int>(k), gain * local.value[k]});
  terms.push_back({row.far ? kFarAmbient : kNearAmbient, 1.0});
  for (std::size_t k = 0; k < rows_.common.size(); ++k)
    if (const double share = rows_.common[k].share(row.tau_s); share != 0.0)
      terms.push_back({first_common() + 2 * static_cast<int>(k) + (row.far ? 1 : 0), share});
  if (slopes == Slopes::linear) return;
  terms.push_back({kAlpha, 0.5 * slope * row.tau_s * row.tau_s});
  terms.push_back({kLogDelay, slope * by_log_delay});
  if (row.far)
    terms.insert(terms.end(), {{kLogFarGain, light},
                               {kMismatch, light * row.mismatch},
                               {kBend, light * row.bend},
                               {kOrder, light * row.order}});
  for (std::size_t k = 0; k < steps_.size(); ++k)
    if (const double way = steps_[k].way(row.tau_s); way != 0.0)
      terms.push_back({first_step() + static_cast<int>(k), slope * per_mps * way});
}

void DelayModel::add_rows(Point& point, Slopes slopes) const {
  Line line;
  for (const DelayRows::Row& row : rows_.rows) {
    put_line(row, point.value, line, slopes);
    const double weight = 1.0 / (row.sigma * row.sigma);
    point.cost += 0.5 * weight * line.beyond * line.beyond;
    for (auto one = line.terms.begin(); one != line.terms.end(); ++one) {
      const double scaled = weight * one->slope;
      point.gradient[one->parameter] += scaled * line.beyond;
      point.doubt[one->parameter] += scaled * line.light * row.doubt;
      for (auto other = line.terms.begin(); other <= one; ++other) {
        const auto [lower, upper] = std::minmax(one->parameter, other->parameter);
        point.information(upper, lower) += scaled * other->slope;
      }
    }
  }
  point.information.triangularView<Eigen::StrictlyUpper>() = point.information.transpose();
}

DelayModel::Point DelayModel::at(const Eigen::VectorXd& value, bool with_derivatives) const {
  if (with_derivatives) return about(value, Slopes::all);
  Point point;
  point.value = value;
  point.cost = 0.5 * residuals(value).squaredNorm();
  add_priors(point, false);
  return point;
}

DelayModel::Point DelayModel::about(const Eigen::VectorXd& value, Slopes slopes) const {
  Point point;
  point.value = value;
  point.information = Eigen::MatrixXd::Zero(value.size(), value.size());
  point.gradient = Eigen::VectorXd::Zero(value.size());
  point.doubt = Eigen::VectorXd::Zero(value.size());
  add_rows(point, slopes);
  add_priors(point, true);
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
  if (problem_.log_ratio.std > 0.0)
    add(kLogFarGain, value[kLogFarGain] - problem_.log_ratio.mean, problem_.log_ratio.std);
  add(kMismatch, value[kMismatch], 1.0);
  add(kBend, value[kBend], 1.0);
  add(kOrder, value[kOrder], 1.0);
  for (int k = 0; k < curve_.size(); ++k)
    add(kDelayParameters + k, value[kDelayParameters + k], kCoefficientStd);
  for (int k = first_common(); k < first_step(); ++k) add(k, value[k], kCommonStd);

  const double speed_mps = problem_.pose.baseline_m.mean * std::exp(-value[kLogDelay]);
  const double residual = value[kAlpha] * speed_mps / kAccelerationStd_mps2;
  point.cost += 0.5 * residual * residual;
  if (!with_derivatives) return;
  const std::array<Term, 2> terms{Term{kAlpha, speed_mps / kAccelerationStd_mps2},
                                  Term{kLogDelay, -residual}};
  for (const Term& one : terms) {
    point.gradient[one.parameter] += one.slope * residual;
    for (const Term& other : terms)
      point.information(one.parameter, other.parameter) += one.slope * other.slope;
  }
}

double DelayModel::refit(Eigen::VectorXd& value) const {
  const Eigen::Index n = first_step() - kNearAmbient;
  const Point point = about(value, Slopes::linear);
  const auto gradient = point.gradient.segment(kNearAmbient, n);
  const Eigen::VectorXd step =
      point.information.block(kNearAmbient, kNearAmbient, n, n).ldlt().solve(gradient);
  value.segment(kNearAmbient, n) -= step;
  return point.cost - 0.5 * gradient.dot(step);
}

DelayModel::Point DelayModel::minimise(Eigen::VectorXd value, bool move_delay, int most_iterations,
                                       const std::vector<int>& held) const {
  constexpr double kEnough = 1e-4;  // of half a chi-square
  std::vector<int> moved = free(move_delay);
  std::erase_if(moved, [&](int k) { return std::ranges::find(held, k) != held.end(); });
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
    const bool allowed = there.value.allFinite() && drives_on(there.value);
    if (allowed) there.cost = move_delay ? refit(there.value) : at(there.value, false).cost;
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
    found[static_cast<Eigen::Index>(i)] =
        (light_of(row, value).light + other_light(row, value) - row.power) / row.sigma;
  }
  return found;
}

}  // namespace vildar
