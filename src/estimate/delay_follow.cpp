#include "estimate/delay_follow.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include <Eigen/Eigenvalues>

#include "estimate/common_light.h"

namespace vildar {
namespace {

Outcome<Followed> follow_beside(const DelayProblem& problem, DelayRows rows, double delay_s) {
  auto outcome = best_delay_curve(problem, rows, delay_s);
  if (const Miss* miss = std::get_if<Miss>(&outcome)) return *miss;
  Followed found{std::move(rows), std::get<DelayCurve>(std::move(outcome)), {}, {}};
  found.steps_s = delay_steps_s(found.rows);
  if (found.steps_s.empty()) return Miss::below_noise;
  auto motion =
      find_delay_motion(found.model(problem), found.rows, found.steps_s, found.steady.value);
  if (!motion) return Miss::not_converged;
  found.motion = std::move(*motion);
  return found;
}

// The next, by the rows' own sigmas: a curve that is too stiff for it, or for how the vehicle
// moves, made them grow.
std::optional<FoundLight> common_light_beside(const DelayProblem& problem, const DelayRows& rows,
                                              const Followed& found) {
  const DelayModel model(problem, rows, CubicSpline(found.steady.breaks), found.steps_s);
  DelayMotion motion = found.motion;
  if (!std::ranges::equal(rows.rows, found.rows.rows, {}, &DelayRows::Row::sigma,
                          &DelayRows::Row::sigma)) {
    auto again = find_delay_motion(model, rows, found.steps_s, found.steady.value);
    if (!again) return std::nullopt;
    motion = std::move(*again);
  }
  return find_common_light(
      model, rows,
      {motion.value, true, motion.step_precision, motion.noise_factor, problem.log_ratio});
}

bool own_light_prevails(const DelayProblem& problem, const Followed& found) {
  constexpr double kFaint = 0.05;  // of the vehicle's light
  const DelayModel model = found.model(problem);
  double own = 0.0;
  std::array<double, 2> least{}, most{};
  for (const DelayRows::Row& row : found.rows.rows) {
    own = std::max(own, model.brightness_of(row, found.motion.value).light);
    const double others = model.common_light(row, found.motion.value);
    least[row.far] = std::min(least[row.far], others);
    most[row.far] = std::max(most[row.far], others);
  }
  const bool apart = std::ranges::any_of(
      model.common_powers(found.motion.value), [&](const std::array<double, 2>& power) {
        return power[0] * power[1] < 0.0 &&
               std::min(std::abs(power[0]), std::abs(power[1])) > kFaint * own;
      });
  return !apart && std::max(most[0] - least[0], most[1] - least[1]) < own;
}

// How much more the far side receives where the near one receives one unit more, at once: total
// least squares of what they receive at the same times.
double ratio_at_once(const DelayRows& rows) {
  const auto far = std::ranges::find(rows.rows, true, &DelayRows::Row::far);
  const std::span<const DelayRows::Row> near_rows(rows.rows.begin(), far);
  std::vector<Eigen::Vector2d> pairs;
  for (const DelayRows::Row& row : std::ranges::subrange(far, rows.rows.end())) {
    const auto after = std::ranges::upper_bound(near_rows, row.tau_s, {}, &DelayRows::Row::tau_s);
    if (after == near_rows.begin() || after == near_rows.end()) continue;
    const auto before = std::prev(after);
    const double share = (row.tau_s - before->tau_s) / (after->tau_s - before->tau_s);
    pairs.emplace_back(before->power + share * (after->power - before->power), row.power);
  }
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& pair : pairs) mean += pair / static_cast<double>(pairs.size());
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& pair : pairs) scatter += (pair - mean) * (pair - mean).transpose();
  const Eigen::Vector2d most =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(scatter).eigenvectors().col(1);
  return most[1] / most[0];
}

double chi2_at_once(const DelayProblem& problem, const Followed& found, DelayRows rows) {
  constexpr double kNone_s = 1e-6;
  constexpr std::size_t kMoreLights = 3;
  DelayProblem any_level = problem;
  constexpr double kAnyLevel = 10.0;  // of the light
  for (DelaySide* side : {&any_level.near, &any_level.far})
    side->ambient_w.std = kAnyLevel * found.rows.unit_w;
  rows.common.clear();
  const std::size_t lights = found.rows.common.empty() ? 0 : found.rows.common.size() + kMoreLights;
  for (;;) {
    const DelayModel model(any_level, rows,
                           CubicSpline(delay_breaks(rows, kNone_s, found.steady.pieces())));
    const Eigen::VectorXd value = model.minimise(model.start(kNone_s), false, 1).value;
    const auto next =
        rows.common.size() < lights
            ? find_common_light(model, rows, {value, false, 0.0, 1.0, problem.log_ratio})
            : std::nullopt;
    if (!next) return model.residuals(value).squaredNorm();
    rows.common.push_back(next->light);
  }
}

}  // namespace

Outcome<Followed> follow(const DelayProblem& problem, const DelayRows& rows, double delay_s) {
  constexpr std::size_t kMostLights = 4;
  constexpr double kOfShift = 2.5;  // half of it where the light is just told
  auto alone = follow_beside(problem, rows, delay_s);
  DelayRows beside = rows;
  double doubt2 = 0.0;
  for (Outcome<Followed> outcome = alone; auto* found = std::get_if<Followed>(&outcome);) {
    found->common_doubt = std::sqrt(doubt2);
    const auto next = common_light_beside(problem, beside, *found);
    if (!next && !own_light_prevails(problem, *found)) return Miss::outside_model;
    if (!next) return outcome;
    if (beside.common.size() == kMostLights) break;
    beside.common.push_back(next->light);
    const double before = found->motion.value[kLogDelay];
    outcome = follow_beside(problem, beside, delay_s);
    if (const auto* later = std::get_if<Followed>(&outcome))
      doubt2 += std::pow(kOfShift * (later->motion.value[kLogDelay] - before), 2) / next->chi2;
  }
  return alone;
}

bool told_from_no_delay(const DelayProblem& problem, const Followed& found, double chi2) {
  if (!(chi2_at_once(problem, found, found.rows) > chi2)) return false;
  const double ratio = ratio_at_once(found.rows);
  if (!(std::abs(ratio) > 0.0) || !std::isfinite(ratio)) return true;
  DelayProblem unlike = problem;
  DelayRows rows = found.rows;
  unlike.log_ratio.mean = std::log(std::abs(ratio));
  if (ratio < 0.0) {
    unlike.far.ambient_w.mean = -problem.far.ambient_w.mean;
    for (DelayRows::Row& row : rows.rows)
      if (row.far) row.power = -row.power;
  }
  return chi2_at_once(unlike, found, std::move(rows)) > chi2;
}

}  // namespace vildar
