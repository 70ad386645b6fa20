#include "estimate/delay_motion.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "estimate/wander.h"

namespace vildar {
namespace {

// Normal equations of the unknowns that tell the motion, all others solved for: 0.5 x' information
// x + gradient' x + const.
struct Reduced {
  std::vector<int> kept;
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient, doubt;
};

std::optional<Reduced> reduce(const DelayModel& model, const DelayModel::Point& point,
                              double noise_factor) {
  Reduced found;
  std::vector<int> others;
  for (const int parameter : model.free(true)) {
    const bool kept = parameter < kNearAmbient;
    (kept ? found.kept : others).push_back(parameter);
  }
  for (int k = model.first_step(); k < point.value.size(); ++k) found.kept.push_back(k);
  const Eigen::LDLT<Eigen::MatrixXd> solver(point.information(others, others));
  if (solver.info() != Eigen::Success || !solver.isPositive()) return std::nullopt;
  const Eigen::MatrixXd across = point.information(others, found.kept);
  const Eigen::MatrixXd response = -solver.solve(across);
  found.information =
      (point.information(found.kept, found.kept) + across.transpose() * response) / noise_factor;
  found.doubt =
      (point.doubt(found.kept) + response.transpose() * point.doubt(others)) / noise_factor;
  found.gradient =
      (point.gradient(found.kept) + response.transpose() * point.gradient(others)) / noise_factor;
  return found;
}

// Variance of the noise from block to block over that which the sigmas say: second differences of
// the residuals, which neither curve nor motion makes.
double noise_factor(const DelayRows& rows, const Eigen::VectorXd& residuals) {
  constexpr double kWhite = 6.0;  // of the square of a second difference
  double sum = 0.0;
  int count = 0;
  for (Eigen::Index i = 0; i + 2 < residuals.size(); ++i) {
    if (rows.rows[static_cast<std::size_t>(i)].far !=
        rows.rows[static_cast<std::size_t>(i + 2)].far)
      continue;
    sum += std::pow(residuals[i] - 2.0 * residuals[i + 1] + residuals[i + 2], 2) / kWhite;
    ++count;
  }
  return count > 0 ? std::max(1.0, sum / count) : 1.0;
}

// That of the model.
AccelerationPrior acceleration_prior(const DelayModel& model, const DelayMotion& found,
                                     const std::vector<int>& kept) {
  const DelayModel::Motion motion = model.motion_at(found.value, 0.0);
  return {motion.acceleration_slopes(kept), motion.acceleration_mps2,
          found.noise_factor * kAccelerationVariance_m2ps4};
}

// How far it wanders is weighed by the evidence.
bool let_wander(const DelayModel& model, double between_s, DelayMotion& found) {
  constexpr int kMostRounds = 20, kHalvings = 4;
  constexpr double kSlack = 0.5, kEnough = 0.1;  // of half a chi-square
  const Eigen::Index steps = found.value.size() - model.first_step();
  for (int round = 0; round < kMostRounds; ++round) {
    const auto reduced = reduce(model, model.at(found.value, true), found.noise_factor);
    if (!reduced) return false;
    const AccelerationPrior prior = acceleration_prior(model, found, reduced->kept);
    const auto mixed = mix_wanders({reduced->information, reduced->gradient}, prior,
                                   found.value.tail(steps), between_s, 1.0);
    if (!mixed) return false;
    found.known = reduced->kept;
    found.covariance = mixed->covariance;
    found.step_precision = mixed->precision;
    found.doubt = found.covariance * reduced->doubt;
    found.acceleration_variance = mixed->acceleration_variance;
    // The way is that of a tangent: where it leads astray it is cut short.
    const auto cost = [&](Eigen::VectorXd& value) {
      return model.refit(value) / found.noise_factor +
             0.5 * mixed->precision * value.tail(steps).squaredNorm();
    };
    const double most = cost(found.value) + kSlack;
    double gained = -INFINITY, share = 1.0;
    for (int halving = 0; gained < 0.0 && halving <= kHalvings; ++halving, share *= 0.5) {
      Eigen::VectorXd there = found.value;
      there(reduced->kept) += share * mixed->moved;
      if (!there.allFinite() || !model.drives_on(there)) continue;
      const double here = cost(there);
      if (here > most) continue;
      gained = most - here;
      found.value = std::move(there);
    }
    if (gained < 0.0) found.covariance += mixed->moved * mixed->moved.transpose();
    if (gained < kSlack + kEnough) break;
  }
  return true;
}

}  // namespace

std::vector<double> delay_steps_s(const DelayRows& rows) {
  std::vector<double> steps_s;
  constexpr int kSteps = 16;
  constexpr double kClearSigmas = 5.0;
  double from_s = INFINITY, to_s = -INFINITY;
  for (const DelayRows::Row& row : rows.rows)
    if (row.root * row.root > kClearSigmas * row.sigma) {
      from_s = std::min(from_s, row.tau_s);
      to_s = std::max(to_s, row.tau_s);
    }
  for (int i = 1; from_s < to_s && i <= kSteps; ++i)
    steps_s.push_back(from_s + (to_s - from_s) * i / (kSteps + 1));
  return steps_s;
}

std::optional<DelayMotion> find_delay_motion(const DelayModel& model, const DelayRows& rows,
                                             std::span<const double> steps_s,
                                             const Eigen::VectorXd& constant) {
  DelayMotion found;
  found.value = model.start(1.0);
  found.value.head(model.first_step()) = constant;
  found.noise_factor = noise_factor(rows, model.residuals(found.value));
  if (!let_wander(model, steps_s[1] - steps_s[0], found)) return std::nullopt;
  return found;
}

}  // namespace vildar
