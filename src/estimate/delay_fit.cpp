#include "estimate/delay_fit.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "estimate/delay_model.h"

namespace vildar {
namespace {

constexpr std::size_t kFewestBlocks = 12;  // of one side
constexpr double kSlowest_mps = 1.0, kFastest_mps = 100.0;
constexpr int kScanPieces = 12;
constexpr std::array<int, 5> kPieces{9, 14, 21, 32, 48};

double departed_m(const std::vector<AccelerationStep>& steps, double tau_s) {
  double sum_m = 0.0;
  for (const AccelerationStep& step : steps) sum_m += step.size * step.way(tau_s);
  return sum_m;
}

void add_side(const DelaySide& side, bool far, DelayRows& rows) {
  for (const PowerBlock& block : side.blocks) {
    const double above_w = std::max(0.0, block.power_w - side.ambient_w.mean);
    const double tau_s = block.time_s - rows.reference_s;
    rows.rows.push_back({tau_s, block.power_w / rows.unit_w, block.sigma_w / rows.unit_w,
                         std::sqrt(above_w / rows.unit_w), far, departed_m(rows.steps, tau_s)});
  }
}

// The reference is the far pulse's peak, about where the delay is known best.
DelayRows rows_of(const DelayProblem& problem) {
  DelayRows rows;
  double brightest_w = 0.0;
  for (const DelaySide* side : {&problem.near, &problem.far})
    for (const PowerBlock& block : side->blocks)
      brightest_w = std::max(brightest_w, block.power_w - side->ambient_w.mean);
  rows.unit_w = brightest_w;
  rows.reference_s = std::max_element(problem.far.blocks.begin(), problem.far.blocks.end(),
                                      [](const PowerBlock& a, const PowerBlock& b) {
                                        return a.power_w < b.power_w;
                                      })
                         ->time_s;
  for (const AccelerationJump& jump : problem.acceleration.jumps) {
    const double tau_s = jump.time_s - rows.reference_s;
    rows.steps.push_back({tau_s, tau_s > 0.0 ? jump.by_mps2 : -jump.by_mps2});
  }
  add_side(problem.near, false, rows);
  add_side(problem.far, true, rows);
  rows.last_far_s = rows.rows.back().tau_s;
  for (const DelayRows::Row& row : rows.rows) {
    rows.first_s = std::min(rows.first_s, row.tau_s);
    rows.last_s = std::max(rows.last_s, row.tau_s);
  }
  return rows;
}

// Time and relative rise and fall of the near pulse so far: its root up to the peak, and beyond it
// what it has lost. Only ever grows, so noise adds nothing to it.
std::vector<std::pair<double, double>> rise_of(const DelayRows& rows) {
  std::vector<std::pair<double, double>> path;
  for (const DelayRows::Row& row : rows.rows)
    if (!row.far) path.emplace_back(row.tau_s, row.root);
  const auto peak = std::max_element(
      path.begin(), path.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  const double top = peak->second;
  for (auto at = path.begin(); at != peak; ++at)
    if (at != path.begin()) at->second = std::max(at->second, std::prev(at)->second);
  double highest_later = 0.0;
  for (auto at = std::prev(path.end()); at > peak; --at) {
    highest_later = std::max(highest_later, at->second);
    at->second = 2.0 * top - highest_later;
  }
  return path;
}

// Breaks of the curve, closer where the light changes faster.
std::vector<double> breaks_of(const DelayRows& rows, double delay_s, int pieces) {
  constexpr double kRise = 1.5;  // pieces of the rise over those of the time
  auto path = rise_of(rows);     // u, share of the way
  const double span_s = rows.last_s - rows.first_s + delay_s;
  for (auto& [tau_s, share] : path) share = (tau_s - rows.first_s) / span_s + kRise * share;
  const double first = rows.first_s, last = rows.last_far_s + delay_s > rows.last_s
                                                ? rows.last_far_s + delay_s
                                                : rows.last_s;
  if (last > path.back().first) path.emplace_back(last, path.back().second + 1.0 / pieces);
  if (first < path.front().first) path.emplace(path.begin(), first, 0.0);
  std::vector<double> breaks{first};
  std::size_t i = 0;
  for (int piece = 1; piece < pieces; ++piece) {
    const double wanted = path.front().second + (path.back().second - path.front().second) *
                                                    static_cast<double>(piece) / pieces;
    while (i + 2 < path.size() && path[i + 1].second < wanted) ++i;
    const double share =
        std::clamp((wanted - path[i].second) / (path[i + 1].second - path[i].second), 0.0, 1.0);
    const double u = path[i].first + share * (path[i + 1].first - path[i].first);
    if (u > breaks.back()) breaks.push_back(u);
  }
  if (last > breaks.back()) breaks.push_back(last);
  return breaks;
}

// The delay that a coarse curve fits best, with constant speed.
double scan_delay_s(const DelayProblem& problem, const DelayRows& rows) {
  constexpr double kStep = 1.2;
  double best_s = 0.0, least = INFINITY;
  for (double speed_mps = kFastest_mps; speed_mps > kSlowest_mps; speed_mps /= kStep) {
    const double delay_s = problem.baseline_m.mean / speed_mps;
    if (delay_s > 0.5 * (rows.last_s - rows.first_s)) break;
    const DelayModel model(problem, rows, CubicSpline(breaks_of(rows, delay_s, kScanPieces)));
    const double cost = model.minimise(model.start(delay_s), false, 1).cost;
    if (cost < least) {
      least = cost;
      best_s = delay_s;
    }
  }
  return best_s;
}

// Variance factor of residuals: scatter beyond the sigmas, and correlation of neighbours where it
// stands out of chance. The curve takes slow noise with it, which lowers the correlation left.
double variance_factor(const DelayRows& rows, const Eigen::VectorXd& residuals, double unknowns) {
  double square = 0.0, product = 0.0, pairs = 0.0;
  for (Eigen::Index i = 0; i < residuals.size(); ++i) {
    square += residuals[i] * residuals[i];
    if (i == 0 || rows.rows[static_cast<std::size_t>(i)].far !=
                      rows.rows[static_cast<std::size_t>(i - 1)].far)
      continue;
    product += residuals[i] * residuals[i - 1];
    pairs += 1.0;
  }
  const auto n = static_cast<double>(residuals.size());
  const double chi2 = square / std::max(1.0, n - unknowns);
  constexpr double kHighest = 0.95;
  const double lag = product / pairs / (square / n) + unknowns / n;
  const double standing_out = lag > 2.0 / std::sqrt(pairs) ? std::min(lag, kHighest) : 0.0;
  return std::max(1.0, chi2) * (1.0 + standing_out) / (1.0 - standing_out);
}

struct Candidate {
  DelayModel::Point point;
  Eigen::VectorXd residuals;
  std::vector<int> free;
  int pieces = 0;
  double prior_chi2 = 0.0;
  CubicSpline curve;
};

// As many pieces as lower Akaike's information criterion.
Outcome<Candidate> best_curve(const DelayProblem& problem, const DelayRows& rows, double delay_s) {
  Outcome<Candidate> best = Miss::too_few_samples;
  double least = INFINITY;
  const auto n = static_cast<double>(rows.rows.size());
  Eigen::VectorXd last;
  for (const int pieces : kPieces) {
    if (static_cast<double>(pieces) > 0.25 * n) break;
    const CubicSpline curve(breaks_of(rows, delay_s, pieces));
    const DelayModel model(problem, rows, curve);
    Eigen::VectorXd start = model.start(delay_s);
    if (last.size() > 0) start.head<kDelayParameters>() = last;
    DelayModel::Point point = model.minimise(start, false, 1);
    constexpr int kMostIterations = 60;
    point = model.minimise(point.value, true, kMostIterations);
    if (!point.converged) {
      if (std::holds_alternative<Miss>(best)) best = Miss::not_converged;
      continue;
    }
    last = point.value.head<kDelayParameters>();
    Eigen::VectorXd residuals = model.residuals(point.value);
    const double criterion = residuals.squaredNorm() + 2.0 * pieces;
    if (!(criterion < least)) continue;
    least = criterion;
    const double prior_chi2 = model.prior_chi2(point.value);
    best = Candidate{std::move(point), std::move(residuals), model.free(true),
                     pieces,           prior_chi2,           curve};
  }
  return best;
}

// Speed and acceleration some time after the reference.
Eigen::Vector2d motion_at(const DelayProblem& problem, const DelayRows& rows,
                          const Eigen::VectorXd& value, double tau_s) {
  const double at_reference_mps = problem.baseline_m.mean * std::exp(-value[kLogDelay]);
  Eigen::Vector2d motion(at_reference_mps * (1.0 + value[kAlpha] * tau_s),
                         at_reference_mps * value[kAlpha]);
  for (const AccelerationStep& step : rows.steps) {
    motion[0] += step.size * step.beyond_s(tau_s);
    if (step.beyond_s(tau_s) != 0.0) motion[1] += step.size;
  }
  return motion;
}

// What the doubt about the jumps of acceleration adds to the covariance of speed and acceleration:
// the fit is moved along each of its main directions.
Eigen::Matrix2d doubt_of_jumps(const DelayProblem& problem, const DelayRows& rows,
                               const Candidate& found, double tau_s) {
  constexpr double kLeastShare = 1e-3;
  const Eigen::MatrixXd& covariance = problem.acceleration.covariance;
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  if (covariance.size() == 0) return sum;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(covariance);
  const Eigen::Vector2d here = motion_at(problem, rows, found.point.value, tau_s);
  for (Eigen::Index k = 0; k < covariance.rows(); ++k) {
    const double variance = eigen.eigenvalues()[k];
    if (!(variance > kLeastShare * covariance.trace())) continue;
    DelayRows moved = rows;
    for (std::size_t i = 0; i < moved.steps.size(); ++i) {
      const double by = std::sqrt(variance) * eigen.eigenvectors()(static_cast<Eigen::Index>(i), k);
      moved.steps[i].size += moved.steps[i].tau_s > 0.0 ? by : -by;
    }
    for (DelayRows::Row& row : moved.rows) row.departed_m = departed_m(moved.steps, row.tau_s);
    const DelayModel model(problem, moved, found.curve);
    const Eigen::Vector2d apart =
        motion_at(problem, moved, model.minimise(found.point.value, true, 1).value, tau_s) - here;
    sum += apart * apart.transpose();
  }
  return sum;
}

// Speed, its sigma and its time from the delay and the acceleration, at the time that suits best.
void put_speed(const DelayProblem& problem, const DelayRows& rows, const Candidate& found,
               const Eigen::Matrix2d& covariance, DelayFit& fit) {
  constexpr double kTwoSided95 = 1.959963984540054;
  const double alpha = found.point.value[kAlpha];
  const double at_reference_mps = problem.baseline_m.mean * std::exp(-found.point.value[kLogDelay]);
  double least = INFINITY, best_s = 0.0;
  constexpr int kSteps = 32;
  for (int i = 0; i <= kSteps; ++i) {
    const double tau_s = rows.first_s + (rows.last_s - rows.first_s) * i / kSteps;
    const Eigen::Vector2d slope(-1.0, tau_s / (1.0 + alpha * tau_s));
    const double variance = slope.dot(covariance * slope);
    if (variance < least) {
      least = variance;
      best_s = tau_s;
    }
  }
  // As if the acceleration were constant, and then as it is.
  const Eigen::Vector2d constant(at_reference_mps * (1.0 + alpha * best_s),
                                 at_reference_mps * alpha);
  const Eigen::Vector2d motion = motion_at(problem, rows, found.point.value, best_s);
  const double speed_mps = motion[0];
  fit.acceleration_mps2 = motion[1];
  // Of speed and acceleration by ln delay and alpha; the baseline scales both.
  Eigen::Matrix2d slopes;
  slopes << -constant[0], at_reference_mps * best_s, -constant[1], at_reference_mps;
  const double baseline_share = problem.baseline_m.std / problem.baseline_m.mean;
  fit.covariance = slopes * covariance * slopes.transpose() +
                   baseline_share * baseline_share * constant * constant.transpose() +
                   doubt_of_jumps(problem, rows, found, best_s);
  fit.acceleration_std_mps2 = std::sqrt(fit.covariance(1, 1));
  SpeedEstimate& speed = fit.speed;
  speed.time_s = rows.reference_s + best_s;
  speed.speed_mps = speed_mps;
  speed.std_mps = std::sqrt(fit.covariance(0, 0));
  const double log_std = speed.std_mps / speed_mps;
  speed.lo95_mps = speed_mps * std::exp(-kTwoSided95 * log_std);
  speed.hi95_mps = speed_mps * std::exp(kTwoSided95 * log_std);
  for (const DelaySide* side : {&problem.near, &problem.far})
    for (const PowerBlock& block : side->blocks) speed.samples_used += block.samples;
}

}  // namespace

Outcome<DelayFit> fit_delay(const DelayProblem& problem) {
  if (std::min(problem.near.blocks.size(), problem.far.blocks.size()) < kFewestBlocks)
    return Miss::too_few_samples;
  const DelayRows rows = rows_of(problem);
  if (!(rows.unit_w > 0.0)) return Miss::below_noise;
  const double delay_s = scan_delay_s(problem, rows);
  if (!(delay_s > 0.0)) return Miss::too_few_samples;
  const auto outcome = best_curve(problem, rows, delay_s);
  if (const Miss* miss = std::get_if<Miss>(&outcome)) return *miss;
  const Candidate* found = &std::get<Candidate>(outcome);

  const Eigen::MatrixXd information = found->point.information(found->free, found->free);
  const Eigen::LDLT<Eigen::MatrixXd> solver(information);
  if (solver.info() != Eigen::Success || !solver.isPositive()) return Miss::not_converged;
  const Eigen::MatrixXd all =
      solver.solve(Eigen::MatrixXd::Identity(information.rows(), information.cols()));
  const auto n = static_cast<double>(rows.rows.size());
  const auto unknowns = static_cast<double>(found->free.size());
  const double factor = variance_factor(rows, found->residuals, unknowns);
  // Free parameters begin with both ambient levels, then delay and acceleration.
  const Eigen::Matrix2d covariance = factor * all.block<2, 2>(2, 2);
  DelayFit fit;
  fit.chi2_per_dof = found->residuals.squaredNorm() / std::max(1.0, n - unknowns);
  fit.sigma_factor = std::sqrt(factor);
  fit.pieces = found->pieces;
  fit.log_ratio = found->point.value[kLogFarGain];
  if (problem.log_ratio.std > 0.0) fit.log_ratio_std = std::sqrt(all(4, 4));

  constexpr double kWorstMismatch = 0.03;  // rms of the light
  double error2 = 0.0, light2 = 0.0;
  for (std::size_t i = 0; i < rows.rows.size(); ++i) {
    error2 += std::pow(found->residuals[static_cast<Eigen::Index>(i)] * rows.rows[i].sigma, 2);
    light2 += std::pow(rows.rows[i].root, 4);
  }
  const double expected = 4.0;  // of chi-square, below which noise explains any mismatch
  if (fit.chi2_per_dof > expected && error2 > kWorstMismatch * kWorstMismatch * light2)
    return Miss::bad_fit;
  // The chance of more, with three priors, is one in a hundred thousand.
  constexpr double kMostPriorChi2 = 25.0;
  if (found->prior_chi2 > kMostPriorChi2) return Miss::bad_fit;
  constexpr double kNoDelay = 0.3;
  if (!(std::sqrt(covariance(0, 0)) < kNoDelay)) return Miss::too_uncertain;
  put_speed(problem, rows, *found, covariance, fit);
  return fit;
}

}  // namespace vildar
