#include "estimate/delay_fit.h"

#include <algorithm>
#include <cmath>

#include "estimate/delay_follow.h"
#include "estimate/light_checks.h"
#include "estimate/wander.h"

namespace vildar {
namespace {

constexpr std::size_t kFewestBlocks = 12;  // of one side
constexpr double kSlowest_mps = 1.0, kFastest_mps = 100.0;
constexpr int kScanPieces = 12;

// What pieces as long as a block may miss of each block's light: a share of its fourth differences,
// of which a cubic has none. Across a gap there are none. Where light bends or ends within a block,
// as at the edge of a view, they are as large as the second ones.
std::vector<double> unresolved_w(const std::vector<PowerBlock>& blocks) {
  constexpr double kShare = 0.03, kShareAtOnce = 0.2;
  constexpr double kClearSigmas = 40.0;  // five of a fourth difference's
  constexpr std::ptrdiff_t kReach = 2;
  const auto n = static_cast<std::ptrdiff_t>(blocks.size());
  std::vector<double> missed_w(blocks.size(), 0.0);
  for (std::ptrdiff_t i = kReach; i + kReach < n; ++i) {
    const PowerBlock* at = blocks.data() + i;
    if (at[kReach].time_s - at[-kReach].time_s > (2 * kReach + 0.5) * at->duration_s) continue;
    const double fourth_w = at[-2].power_w - 4.0 * at[-1].power_w + 6.0 * at->power_w -
                            4.0 * at[1].power_w + at[2].power_w;
    double second_w = 0.0;
    for (std::ptrdiff_t near = -1; near <= 1; ++near)
      second_w = std::max(
          second_w, std::abs(at[near - 1].power_w - 2.0 * at[near].power_w + at[near + 1].power_w));
    const bool at_once = std::abs(fourth_w) > std::max(second_w, kClearSigmas * at->sigma_w);
    const double missed_here_w = (at_once ? kShareAtOnce : kShare) * std::abs(fourth_w);
    for (std::ptrdiff_t near = -kReach; near <= kReach; ++near) {
      double& missed = missed_w[static_cast<std::size_t>(i + near)];
      missed = std::max(missed, missed_here_w);
    }
  }
  return missed_w;
}

void add_side(const DelaySide& side, bool far, DelayRows& rows) {
  const std::vector<double> missed_w = unresolved_w(side.blocks);
  for (std::size_t i = 0; i < side.blocks.size(); ++i) {
    const PowerBlock& block = side.blocks[i];
    const double above_w = std::max(0.0, block.power_w - side.ambient_w.mean);
    const double tau_s = block.time_s - rows.reference_s;
    rows.rows.push_back({tau_s, block.power_w / rows.unit_w,
                         std::hypot(block.sigma_w, missed_w[i]) / rows.unit_w,
                         std::sqrt(above_w / rows.unit_w), far});
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
  rows.block_s = problem.near.blocks.front().duration_s;
  add_side(problem.near, false, rows);
  add_side(problem.far, true, rows);
  rows.last_far_s = rows.rows.back().tau_s;
  for (const DelayRows::Row& row : rows.rows) {
    rows.first_s = std::min(rows.first_s, row.tau_s);
    rows.last_s = std::max(rows.last_s, row.tau_s);
  }
  return rows;
}

// How far ahead of a photodiode a vehicle is so long before its light ends, as if that were at 59
// degrees off the road, between headlamps' beams (half a right angle) and wide views.
double ahead_at_m(const DelayProblem& problem, double speed_mps, double before_s) {
  constexpr double kEnd = 0.6;
  return kEnd * problem.pose.perpendicular_m + speed_mps * std::max(0.0, before_s);
}

// Of the angle: an error that the speed may have, or found with it.
enum class Mismatch { doubted, found };

// What the far photodiode would have received as the near one does, and how well that is known, at
// a constant speed. Its blocks become less sure by a part of the mismatch, which under wide angles
// is larger than any noise; not by more than that of 1 %, or whatever is unlike would pass for it.
DelayRows as_of_near(const DelayProblem& problem, Mismatch mismatch, double delay_s,
                     DelayRows rows) {
  constexpr double kCompared_rad = 0.35, kOfMismatch = 0.25, kLarge = 0.01;
  constexpr double kBent = 0.4;              // of the mismatch
  constexpr double kComparedSecant = 0.134;  // half of -ln cos of 0.7 rad
  const double d_m = problem.pose.perpendicular_m;
  const double speed_mps = problem.pose.baseline_m.mean / delay_s;
  const double passed_s = problem.far.passed_s - rows.reference_s;
  const double ambient = problem.far.ambient_w.mean / rows.unit_w;
  const auto counted = [&](double mismatch) {
    return kOfMismatch * std::pow(std::min(mismatch, kLarge), 2) / kLarge;
  };
  for (DelayRows::Row& row : rows.rows) {
    if (!row.far) continue;
    const double ahead_m = ahead_at_m(problem, speed_mps, passed_s - row.tau_s);
    const double angle = std::atan2(d_m, ahead_m) / kCompared_rad;
    const UnlikeLight unlike = unlike_at(problem.pose.unlike, ahead_m);
    const double share = std::exp(-unlike.log_ratio);
    row.power = ambient + share * (row.power - ambient);
    row.root *= std::sqrt(share);
    row.doubt = unlike.doubt;
    if (mismatch == Mismatch::doubted) {
      row.doubt += problem.log_ratio.std * angle;
    } else {
      row.mismatch = problem.log_ratio.std * angle;
      row.bend = kBent * problem.log_ratio.std * angle * (angle - 1.0);
      row.order =
          problem.log_ratio.std * log_secant_at(problem.pose.off_axis, ahead_m) / kComparedSecant;
    }
    const double light = row.root * row.root;
    row.sigma = std::hypot(share * row.sigma, counted(problem.log_ratio.std) * angle * light,
                           counted(unlike.doubt) * light);
  }
  return rows;
}

// The delay that a coarse curve fits best, with constant speed.
double scan_delay_s(const DelayProblem& problem, const DelayRows& rows) {
  constexpr double kStep = 1.2;
  double best_s = 0.0, least = INFINITY;
  for (double speed_mps = kFastest_mps; speed_mps > kSlowest_mps; speed_mps /= kStep) {
    const double delay_s = problem.pose.baseline_m.mean / speed_mps;
    if (delay_s > 0.5 * (rows.last_s - rows.first_s)) break;
    const DelayModel model(problem, rows, CubicSpline(delay_breaks(rows, delay_s, kScanPieces)));
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

// Whether both photodiodes saw for the most part one stretch of the road: else one curve is any two
// pulses.
bool share_a_stretch(const DelayProblem& problem, const DelayRows& rows, const DelayModel& model,
                     const Eigen::VectorXd& value) {
  constexpr int kTimes = 33;
  constexpr double kMostApart = 0.5;
  double mean_mps = 0.0;
  for (int i = 0; i < kTimes; ++i)
    mean_mps +=
        model.motion_at(value, rows.first_s + (rows.last_s - rows.first_s) * (i + 0.5) / kTimes)
            .speed_mps /
        kTimes;
  return problem.pose.baseline_m.mean < kMostApart * mean_mps * (rows.last_s - rows.first_s);
}

// Most by which the speed leaves the straight line nearest to it.
double bend_mps(const DelayRows& rows, const DelayModel& model, const Eigen::VectorXd& value) {
  constexpr int kTimes = 33;
  Eigen::MatrixX2d line(kTimes, 2);
  Eigen::VectorXd speeds_mps(kTimes);
  for (int i = 0; i < kTimes; ++i) {
    const double tau_s = rows.first_s + (rows.last_s - rows.first_s) * i / (kTimes - 1);
    line.row(i) << 1.0, tau_s;
    speeds_mps[i] = model.motion_at(value, tau_s).speed_mps;
  }
  const Eigen::Vector2d nearest =
      (line.transpose() * line).ldlt().solve(line.transpose() * speeds_mps);
  return (speeds_mps - line * nearest).cwiseAbs().maxCoeff();
}

// The hardest that the vehicle surely braked and sped up.
void put_hardest(const DelayRows& rows, const DelayModel& model, const DelayMotion& found,
                 DelayFit& fit) {
  constexpr int kTimes = 33;
  constexpr double kSigmas = 2.0;
  const double widened = fit.sigma_factor * fit.sigma_factor / found.noise_factor;
  for (int i = 0; i < kTimes; ++i) {
    const double tau_s = rows.first_s + (rows.last_s - rows.first_s) * i / (kTimes - 1);
    const DelayModel::Motion motion = model.motion_at(found.value, tau_s);
    const Eigen::VectorXd slopes = motion.acceleration_slopes(found.known);
    const double doubt_mps2 =
        kSigmas * std::hypot(std::sqrt(widened * slopes.dot(found.covariance * slopes)),
                             slopes.dot(found.doubt));
    fit.surely_brakes_mps2 =
        std::max(fit.surely_brakes_mps2, -motion.acceleration_mps2 - doubt_mps2);
    fit.surely_speeds_up_mps2 =
        std::max(fit.surely_speeds_up_mps2, motion.acceleration_mps2 - doubt_mps2);
  }
}

// Who drifts to the side comes into brighter or fainter light, which passes for way driven: of a
// light that were one function of the distance times one of the angle, by how its slope along the
// road differs from that of the distance alone. Mean over the far pulse, as it tells the delay.
double drift_std_mps(const DelayProblem& problem, const DelayRows& rows, const DelayModel& model,
                     const DelayMotion& found) {
  constexpr double kDrift_mps = 0.03;  // rms, of 4 cm to and fro within six seconds
  constexpr double kFall = 2.0;        // inverse square
  const double reference_mps = model.motion_at(found.value, 0.0).speed_mps;
  const double passed_s = problem.far.passed_s - rows.reference_s;
  double both = 0.0, ahead = 0.0;
  for (const DelayRows::Row& row : rows.rows) {
    if (!row.far) continue;
    const auto [light, per_way_s] = model.brightness_of(row, found.value);
    const double speed_mps = model.motion_at(found.value, row.tau_s).speed_mps;
    const double ahead_m = ahead_at_m(problem, speed_mps, passed_s - row.tau_s);
    const double by_ahead = -per_way_s / reference_mps / row.sigma;
    const double by_aside =
        -(by_ahead * ahead_m + kFall * light / row.sigma) / problem.pose.perpendicular_m;
    both += by_ahead * by_aside;
    ahead += by_ahead * by_ahead;
  }
  return ahead > 0.0 ? kDrift_mps * std::abs(both) / ahead : 0.0;
}

// Speed and acceleration with their covariance at that of the times asked for at which the speed is
// known best.
void put_speed(const DelayProblem& problem, const Followed& followed, const DelayModel& model,
               DelayFit& fit) {
  const DelayRows& rows = followed.rows;
  const DelayMotion& found = followed.motion;
  constexpr double kTwoSided95 = 1.959963984540054;
  const double baseline_share = problem.pose.baseline_m.std / problem.pose.baseline_m.mean;
  const double widened = fit.sigma_factor * fit.sigma_factor / found.noise_factor;
  const auto slopes_of = [&](const DelayModel::Motion& motion) {
    Eigen::MatrixX2d slopes(found.covariance.rows(), 2);
    slopes << motion.speed_slopes(found.known), motion.acceleration_slopes(found.known);
    return slopes;
  };
  const auto of_noise = [&](const Eigen::MatrixX2d& slopes) -> Eigen::Matrix2d {
    return widened * slopes.transpose() * found.covariance * slopes;
  };
  const auto turned_mps = [&](double tau_s) {
    return kDelayAccelerationDoubt_mps2 * (rows.reference_s + tau_s - fit.surest_s);
  };
  const auto surest_tau_s = [&](double from_s, double to_s, const auto& std_mps) {
    constexpr int kTimes = 32;
    double least = INFINITY, surest_s = from_s;
    for (int i = 0; i <= kTimes; ++i) {
      const double tau_s = from_s + (to_s - from_s) * i / kTimes;
      const DelayModel::Motion motion = model.motion_at(found.value, tau_s);
      const double relative = std_mps(tau_s, slopes_of(motion)) / motion.speed_mps;
      if (!(relative < least)) continue;
      least = relative;
      surest_s = tau_s;
    }
    return surest_s;
  };
  fit.surest_s =
      rows.reference_s + surest_tau_s(rows.first_s, rows.last_s, [&](double, const auto& slopes) {
        return std::sqrt(of_noise(slopes)(0, 0));
      });
  const DelayModel steady = followed.steady_model(problem);
  // Of the other optima: how a mismatch goes with the angle is not known well enough to let
  // chi-square alone choose between them.
  const auto of_optima = [&](double tau_s) -> Eigen::Matrix2d {
    constexpr double kCounts = 0.1;  // of chi-square, where all is known a half
    const auto at = [&](const Eigen::VectorXd& value) {
      const DelayModel::Motion motion = steady.motion_at(value, tau_s);
      return Eigen::Vector2d(motion.speed_mps, motion.acceleration_mps2);
    };
    const Eigen::Vector2d here = at(followed.steady.value);
    Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
    double weights = 1.0;
    for (const DelayCurve::Other& other : followed.steady.others) {
      const double weight = std::exp(-kCounts * other.more_chi2 / found.noise_factor);
      const Eigen::Vector2d apart = at(other.value) - here;
      weights += weight;
      sum += weight * apart * apart.transpose();
    }
    return sum / weights;
  };
  // What they receive unlike where they stand: of that which the acceleration tells, which vehicles
  // seldom have so much of, more is there than its std.
  const auto told_sigmas = [&](double tau_s, const Eigen::MatrixX2d& slopes) {
    const double response = slopes.col(1).dot(found.doubt);
    const double acceleration = model.motion_at(found.value, tau_s).acceleration_mps2;
    const double both = response * response + kAccelerationVariance_m2ps4;
    const double mean = acceleration * response / both;
    const double variance = kAccelerationVariance_m2ps4 / both;
    return std::max(1.0, std::sqrt(mean * mean + variance));
  };
  const auto of_all = [&](double tau_s, const Eigen::MatrixX2d& slopes) -> Eigen::Matrix2d {
    const Eigen::Vector2d unlike = told_sigmas(tau_s, slopes) * slopes.transpose() * found.doubt;
    return of_noise(slopes) + of_optima(tau_s) + unlike * unlike.transpose();
  };
  // How it goes with the angle is not known well enough to say when it leaves the speed alone: that
  // may be in half as much time again before the end, or two thirds of it.
  constexpr double kOfDoubt = 0.3, kElsewhere = 1.5;
  const auto unlike_mps = [&](double tau_s) {
    double most_mps = 0.0;
    for (const double share : {1.0 / kElsewhere, kElsewhere}) {
      const double at_s = std::max(rows.first_s, rows.last_s - share * (rows.last_s - tau_s));
      most_mps = std::max(
          most_mps,
          std::abs(model.motion_at(found.value, at_s).speed_slopes(found.known).dot(found.doubt)));
    }
    return kOfDoubt * most_mps;
  };
  const auto std_mps = [&](double tau_s, const Eigen::MatrixX2d& slopes) {
    return std::hypot(std::sqrt(of_all(tau_s, slopes)(0, 0)), turned_mps(tau_s),
                      std::pow(told_sigmas(tau_s, slopes), 2) * unlike_mps(tau_s));
  };
  const double from_s =
      std::clamp(problem.asked_from_s - rows.reference_s, rows.first_s, rows.last_s);
  const double to_s = std::clamp(problem.asked_to_s - rows.reference_s, from_s, rows.last_s);
  const double tau_s = surest_tau_s(from_s, to_s, std_mps);
  const DelayModel::Motion motion = model.motion_at(found.value, tau_s);
  const Eigen::Vector2d both(motion.speed_mps, motion.acceleration_mps2);
  fit.speed.time_s = rows.reference_s + tau_s;
  fit.speed.speed_mps = motion.speed_mps;
  fit.acceleration_mps2 = motion.acceleration_mps2;
  // The baseline scales both.
  fit.covariance =
      of_all(tau_s, slopes_of(motion)) + baseline_share * baseline_share * both * both.transpose();
  fit.drift_std_mps = drift_std_mps(problem, rows, model, found);
  fit.covariance(0, 0) +=
      std::pow(std::pow(told_sigmas(tau_s, slopes_of(motion)), 2) * unlike_mps(tau_s), 2);
  fit.acceleration_std_mps2 = std::sqrt(fit.covariance(1, 1));
  SpeedEstimate& speed = fit.speed;
  speed.std_mps = std::hypot(std::sqrt(fit.covariance(0, 0)), turned_mps(tau_s), fit.drift_std_mps);
  const double log_std = speed.std_mps / speed.speed_mps;
  speed.lo95_mps = speed.speed_mps * std::exp(-kTwoSided95 * log_std);
  speed.hi95_mps = speed.speed_mps * std::exp(kTwoSided95 * log_std);
  for (const DelaySide* side : {&problem.near, &problem.far})
    for (const PowerBlock& block : side->blocks) speed.samples_used += block.samples;
}

// Of DelayFit::gain_chi2: one vehicle in twenty has more, and one in a thousand.
constexpr double kDoubted = 4.0, kDenied = 10.8;

constexpr Eigen::Index kGain = 2;  // among the known

// Of the gain as fitted. From what was said of it data can lead as far as they took its variance
// away, and unlike angular responses further.
double gain_chi2(const Uncertain& log_ratio, const DelayMotion& found) {
  if (!(log_ratio.std > 0.0)) return 0.0;
  constexpr double kLeastTold = 0.2;  // of the variance: the covariance is a mean over wanders
  const double variance = log_ratio.std * log_ratio.std;
  const double told = std::max(kLeastTold * variance, variance - found.covariance(kGain, kGain));
  constexpr double kOfOne = 0.66;  // of chi-square of three, where one's is as improbable
  const double mismatch_chi2 = found.value.segment(kMismatch, 3).squaredNorm();
  return std::max(std::pow(found.value[kLogFarGain] - log_ratio.mean, 2) /
                      (told + std::pow(found.doubt[kGain], 2)),
                  kOfOne * mismatch_chi2);
}

// Responses being as alike as the site says.
Outcome<DelayFit> fit_as_stated(const DelayProblem& problem, Mismatch mismatch) {
  if (std::min(problem.near.blocks.size(), problem.far.blocks.size()) < kFewestBlocks)
    return Miss::too_few_samples;
  const DelayRows measured = rows_of(problem);
  if (!(measured.unit_w > 0.0)) return Miss::below_noise;
  double delay_s = scan_delay_s(problem, measured);
  if (!(delay_s > 0.0)) return Miss::too_few_samples;
  if (!problem.pose.unlike.empty())
    delay_s = scan_delay_s(problem, as_of_near(problem, mismatch, delay_s, measured));
  if (!(delay_s > 0.0)) return Miss::too_few_samples;
  const auto outcome = follow(problem, as_of_near(problem, mismatch, delay_s, measured), delay_s);
  if (const Miss* miss = std::get_if<Miss>(&outcome)) return *miss;
  const auto& found = std::get<Followed>(outcome);
  const auto& [rows, known, steps_s, motion, common_doubt] = found;
  const DelayModel model = found.model(problem);
  if (!share_a_stretch(problem, rows, model, motion.value)) return Miss::bad_fit;
  const Eigen::VectorXd residuals = model.residuals(motion.value);
  const auto n = static_cast<double>(rows.rows.size());
  const auto unknowns = static_cast<double>(model.free(true).size());
  DelayFit fit;
  fit.chi2_per_dof = residuals.squaredNorm() / std::max(1.0, n - unknowns);
  fit.sigma_factor =
      std::sqrt(std::max(motion.noise_factor, variance_factor(rows, residuals, unknowns)));
  fit.pieces = known.pieces();
  fit.common_lights = static_cast<int>(rows.common.size());
  const double steady_chi2 = found.steady_model(problem).residuals(known.value).squaredNorm();
  fit.wander_chi2 = (steady_chi2 - residuals.squaredNorm()) / motion.noise_factor;
  fit.mean_acceleration_mps2 = (model.motion_at(motion.value, steps_s.back()).speed_mps -
                                model.motion_at(motion.value, steps_s.front()).speed_mps) /
                               (steps_s.back() - steps_s.front());
  fit.bend_mps = bend_mps(rows, model, motion.value);
  put_hardest(rows, model, motion, fit);
  fit.log_ratio = motion.value[kLogFarGain];
  if (problem.log_ratio.std > 0.0)
    fit.log_ratio_std = std::hypot(std::sqrt(motion.covariance(kGain, kGain)), motion.doubt[kGain]);

  constexpr double kWorstMismatch = 0.03;  // rms of the light
  double error2 = 0.0, light2 = 0.0;
  for (std::size_t i = 0; i < rows.rows.size(); ++i) {
    error2 += std::pow(residuals[static_cast<Eigen::Index>(i)] * rows.rows[i].sigma, 2);
    light2 += std::pow(rows.rows[i].root, 4);
  }
  const double expected = 4.0;  // of chi-square, below which noise explains any mismatch
  if (fit.chi2_per_dof > expected && error2 > kWorstMismatch * kWorstMismatch * light2)
    return Miss::bad_fit;
  const double rate_mps2 = model.motion_at(motion.value, 0.0).acceleration_mps2;
  constexpr double kMostPriorChi2 = 19.5;  // one in a hundred thousand
  if (rate_mps2 * rate_mps2 > kMostPriorChi2 * motion.acceleration_variance) return Miss::bad_fit;
  fit.gain_chi2 = gain_chi2(problem.log_ratio, motion);
  put_speed(problem, found, model, fit);
  widen(fit, common_doubt * fit.speed.speed_mps);
  constexpr double kNoDelay = 0.3, kToldFromNone = 36.0, kBesideOthers = 200.0;  // of chi-square
  const double told = rows.common.empty() ? kToldFromNone : kBesideOthers;
  if (!(fit.speed.std_mps < kNoDelay * fit.speed.speed_mps) ||
      !told_from_no_delay(problem, found,
                          residuals.squaredNorm() + told * std::pow(fit.sigma_factor, 2)))
    return Miss::too_uncertain;
  return fit;
}

// By how much `other` says another speed of the time of `fit`, and how well both know it.
Uncertain apart_mps(const DelayFit& fit, const DelayFit& other) {
  const double after_s = fit.speed.time_s - other.speed.time_s;
  const Eigen::Vector2d slopes(1.0, after_s);
  const double there_mps = other.speed.speed_mps + other.acceleration_mps2 * after_s;
  return {there_mps - fit.speed.speed_mps,
          std::sqrt(fit.covariance(0, 0) + slopes.dot(other.covariance * slopes))};
}

// A mismatch that is found leaves the speed surer, where it goes with the angle as it is taken to;
// one that is doubted holds where it does not. Where both agree the speed is between them, as each
// is sure; else the surer stands, as far as it is from the other.
Outcome<DelayFit> fit_both(const DelayProblem& problem) {
  constexpr double kSigmas = 2.0, kOfAgreed = 0.5;
  constexpr double kWanders = 15.0;  // of chi-square
  const auto doubted = fit_as_stated(problem, Mismatch::doubted);
  const auto* one = std::get_if<DelayFit>(&doubted);
  if (!one || problem.log_ratio.std < kUnlikeStd) return doubted;
  const auto found = fit_as_stated(problem, Mismatch::found);
  const auto* other = std::get_if<DelayFit>(&found);
  if (!other || other->wander_chi2 > kWanders) return doubted;
  if (other->gain_chi2 > kDoubted) {
    DelayFit fit = *one;
    fit.gain_chi2 = std::max(fit.gain_chi2, other->gain_chi2);
    return fit;
  }
  const bool surer = other->speed.std_mps < one->speed.std_mps;
  DelayFit fit = surer ? *other : *one;
  fit.surest_s = one->surest_s;
  const Uncertain apart = apart_mps(fit, surer ? *one : *other);
  const double off_mps = std::abs(apart.mean);
  if (off_mps < kSigmas * apart.std)
    fit.speed.speed_mps += apart.mean * fit.covariance(0, 0) / (apart.std * apart.std);
  widen(fit, (off_mps < kSigmas * apart.std ? kOfAgreed : 1.0) * off_mps);
  return fit;
}

}  // namespace

Outcome<DelayFit> fit_delay(const DelayProblem& problem) {
  auto outcome = fit_both(problem);
  const auto* fit = std::get_if<DelayFit>(&outcome);
  if (!fit || fit->gain_chi2 < kDoubted) return outcome;
  constexpr double kWorse = 5.0;
  DelayProblem doubted = problem;
  doubted.log_ratio.std *= kWorse;
  outcome = fit_as_stated(doubted, Mismatch::doubted);
  fit = std::get_if<DelayFit>(&outcome);
  if (fit && fit->gain_chi2 > kDenied) return Miss::sensors_contradict;
  return outcome;
}

}  // namespace vildar
