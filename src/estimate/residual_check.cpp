#include "estimate/residual_check.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/median.h"
#include "core/quantity.h"

namespace vildar {
namespace {

double robust_sigma_of(const Eigen::VectorXd& values) {
  return robust_sigma({values.begin(), values.end()});
}

// Unknowns that one image axis of a track determines: offset, slope and bend.
constexpr double kUnknownsPerAxis = 3.0;

// Share of variance common to neighbours in a list of pairs, kept only where it stands out. A fit
// takes slow errors with it, which lowers the correlation left by about its unknowns over the
// pairs.
double correlation(double product_sum, double square_sum, int pairs) {
  if (pairs < 4 || !(square_sum > 0.0)) return 0.0;
  constexpr double kHighest = 0.97;
  const double taken = std::min(0.5, (kUnknownsPerAxis + 1.0) / pairs);
  const double value = (product_sum / square_sum + taken) / (1.0 - taken);
  const double chance = 2.0 / std::sqrt(static_cast<double>(pairs));
  return value > chance ? std::min(value, kHighest) : 0.0;
}

// Mean of each frame's lamps.
Eigen::VectorXd frame_means(const GeometryProblem& problem, const Eigen::VectorXd& residual) {
  std::vector<double> means;
  for (std::size_t i = 0; i < problem.lamps.size(); ++i) {
    const double r = residual[static_cast<Eigen::Index>(i)];
    const bool paired =
        i + 1 < problem.lamps.size() && problem.lamps[i + 1].sighting == problem.lamps[i].sighting;
    means.push_back(paired ? 0.5 * (r + residual[static_cast<Eigen::Index>(++i)]) : r);
  }
  return Eigen::Map<Eigen::VectorXd>(means.data(), static_cast<Eigen::Index>(means.size()));
}

// Share of variance that the two lamps of a frame have in common.
double lamp_correlation(const GeometryProblem& problem, const Eigen::VectorXd& residual) {
  double product = 0.0, square = 0.0;
  int pairs = 0;
  for (std::size_t i = 0; i + 1 < problem.lamps.size(); ++i) {
    if (problem.lamps[i + 1].sighting != problem.lamps[i].sighting) continue;
    const double r = residual[static_cast<Eigen::Index>(i)];
    const double other = residual[static_cast<Eigen::Index>(++i)];
    product += r * other;
    square += 0.5 * (r * r + other * other);
    ++pairs;
  }
  return correlation(product, square, pairs);
}

// Variance factor for fitting a slow function to these residuals as if they were independent.
double correlation_factor(double lamps, const Eigen::VectorXd& frames) {
  double product = 0.0, square = 0.0;
  for (Eigen::Index i = 0; i + 1 < frames.size(); ++i) {
    product += frames[i] * frames[i + 1];
    square += 0.5 * (frames[i] * frames[i] + frames[i + 1] * frames[i + 1]);
  }
  const double lag = correlation(product, square, static_cast<int>(frames.size()) - 1);
  return (1.0 + lamps) * (1.0 + lag) / (1.0 - lag);
}

// Mean power of the cosines of order `first` to `last` in a series.
double cosine_power(const Eigen::VectorXd& series, int first, int last, double degrees) {
  const auto n = static_cast<double>(series.size());
  double power = 0.0;
  for (int k = first; k <= last; ++k) {
    double sum = 0.0;
    for (Eigen::Index i = 0; i < series.size(); ++i)
      sum += series[i] * std::cos(kPi * k * (static_cast<double>(i) + 0.5) / n);
    power += 2.0 / n * sum * sum;
  }
  return power / degrees;
}

// Slow structure of one image axis: its variance, of which a fit's own unknowns have taken some,
// and that over the variance of what is quicker.
struct Slow {
  double variance = 0.0, misfit = 0.0;
};
Slow slow_structure(const Eigen::VectorXd& frames, double nominal_variance) {
  constexpr int kMostWaves = 8, kFewestWaves = 4;
  const int waves = std::min(kMostWaves, static_cast<int>(frames.size()) / 4);
  if (waves < kFewestWaves) return {};
  const double variance = cosine_power(frames, 1, waves, waves - kUnknownsPerAxis + 1.0);
  const double quicker = cosine_power(frames, waves + 1, 3 * waves, 2.0 * waves);
  return {variance, variance / std::max(nominal_variance, quicker)};
}

// What a series of residuals, one for each frame, asks for: as ResidualCheck's sigma_factor and
// misfit. `residuals` went into it, of robust scatter `robust`, with this correlation between the
// lamps of a frame.
struct Judged {
  double factor = 1.0, misfit = 0.0;
};
Judged judge(const Eigen::VectorXd& frames, double residuals, double robust, double lamps) {
  const double correlated = correlation_factor(lamps, frames);
  const double freedom = std::max(0.25 * residuals, residuals - kUnknownsPerAxis * correlated);
  const double scatter = robust * std::sqrt(residuals / freedom);
  Judged found{std::max(1.0, scatter) * std::sqrt(correlated)};
  // As much again where slow structure stands out that neither scatter nor correlation explains.
  constexpr double kStandsOut = 2.0;  // one axis in sixteen by chance
  const double nominal = static_cast<double>(frames.size()) / residuals;
  const Slow slow = slow_structure(frames, nominal);
  if (slow.misfit > kStandsOut)
    found.factor = std::max(found.factor, std::sqrt(slow.variance / nominal));
  found.misfit = slow.misfit;
  return found;
}

void add_bends(const std::vector<double>& series, std::vector<double>& bends) {
  for (std::size_t i = 2; i < series.size(); ++i)
    bends.push_back(series[i] - 2.0 * series[i - 1] + series[i - 2]);
}

// Robust scatter of second differences, over that of independent ones of sigma one. One where they
// are too few.
double scatter_of_bends(std::vector<double> bends) {
  constexpr std::size_t kFewest = 6;
  return bends.size() < kFewest ? 1.0 : robust_sigma(std::move(bends)) / std::sqrt(6.0);
}

// Of what changes from frame to frame in each lamp's residuals.
double quick_scatter(const GeometryProblem& problem, const Eigen::VectorXd& residual) {
  std::vector<double> bends;
  for (const bool left : {true, false}) {
    std::vector<double> own;
    for (std::size_t i = 0; i < problem.lamps.size(); ++i)
      if ((problem.lamps[i].side >= 0.0) == left)
        own.push_back(residual[static_cast<Eigen::Index>(i)]);
    add_bends(own, bends);
  }
  return scatter_of_bends(std::move(bends));
}

// Of how far apart the two lamps of each frame are seen, image u, by its nominal sigma.
std::vector<double> apart_residuals(const GeometryProblem& problem,
                                    const Eigen::Matrix2Xd& residuals) {
  std::vector<double> found;
  for (std::size_t i = 0; i + 1 < problem.lamps.size(); ++i) {
    const LampObservation& one = problem.lamps[i];
    const LampObservation& other = problem.lamps[i + 1];
    if (one.sighting != other.sighting) continue;
    const auto column = static_cast<Eigen::Index>(i++);
    found.push_back(
        (one.sigma.x() * residuals(0, column) - other.sigma.x() * residuals(0, column + 1)) /
        std::hypot(one.sigma.x(), other.sigma.x()));
  }
  return found;
}

// Of what the frames that show both lamps say, each by its squared length: the mean, and by how
// much it changes from the first to the last of them. Their errors are taken to have a fifth of a
// second in common.
struct Tilt {
  Uncertain mean_rad, change_rad;
};
Tilt tilt_of(const GeometryProblem& problem, const Eigen::Matrix2Xd& residuals) {
  constexpr double kTogether_s = 0.2;
  struct Pair {
    double time_s, weight, tilt_rad, variance;
  };
  std::vector<Pair> pairs;
  double weight = 0.0, time = 0.0, tilt = 0.0;
  for (std::size_t i = 0; i + 1 < problem.lamps.size(); ++i) {
    const LampObservation& one = problem.lamps[i];
    const LampObservation& other = problem.lamps[i + 1];
    if (one.sighting != other.sighting) continue;
    const auto column = static_cast<Eigen::Index>(i++);
    const double across = other.normalized.x() - one.normalized.x();
    if (across == 0.0) continue;
    const double off =
        residuals(1, column) * one.sigma.y() - residuals(1, column + 1) * other.sigma.y();
    const double variance = std::pow(one.sigma.y(), 2) + std::pow(other.sigma.y(), 2);
    pairs.push_back({one.time_s, across * across, off / across, variance / (across * across)});
    weight += pairs.back().weight;
    time += pairs.back().weight * one.time_s;
    tilt += pairs.back().weight * pairs.back().tilt_rad;
  }
  if (pairs.empty()) return {};
  time /= weight;
  tilt /= weight;
  double spread = 0.0, slope = 0.0, mean_variance = 0.0, slope_variance = 0.0;
  for (const Pair& pair : pairs) {
    const double lever = pair.weight * (pair.time_s - time);
    spread += lever * (pair.time_s - time);
    slope += lever * pair.tilt_rad;
    mean_variance += pair.weight * pair.weight * pair.variance;
    slope_variance += lever * lever * pair.variance;
  }
  const double span_s = pairs.back().time_s - pairs.front().time_s;
  const double together = std::max(
      1.0, static_cast<double>(pairs.size()) * kTogether_s / std::max(span_s, kTogether_s));
  Tilt found{{tilt, std::sqrt(together * mean_variance) / weight}, {}};
  if (spread > 0.0)
    found.change_rad = {span_s * slope / spread,
                        span_s * std::sqrt(together * slope_variance) / spread};
  return found;
}

// As each axis is judged below.
void judge_apart(const GeometryProblem& problem, const Eigen::Matrix2Xd& residuals,
                 ResidualCheck& check) {
  constexpr std::size_t kFewest = 8;
  const std::vector<double> apart = apart_residuals(problem, residuals);
  if (apart.size() < kFewest) return;
  std::vector<double> bends;
  add_bends(apart, bends);
  check.quick_apart_factor = std::max(1.0, scatter_of_bends(std::move(bends)));
  const double robust = std::max(robust_sigma(apart), 1e-12);
  const Eigen::VectorXd tamed =
      Eigen::Map<const Eigen::VectorXd>(apart.data(), static_cast<Eigen::Index>(apart.size()))
          .cwiseMin(3.0 * robust)
          .cwiseMax(-3.0 * robust);
  const Judged judged = judge(tamed, static_cast<double>(tamed.size()), robust, 0.0);
  check.apart_factor = judged.factor;
  check.apart_misfit = judged.misfit;
}

}  // namespace

void ResidualCheck::widen(double times, const GeometryProblem& problem) {
  sigma_factor = sigma_factor.cwiseMax(times * problem.sigma_factor);
  apart_factor = std::max(apart_factor, times * problem.apart_factor);
}

ResidualCheck check_residuals(const GeometryProblem& problem, const PathVector& parameters,
                              double focal_px) {
  Eigen::Matrix2Xd residuals = bearing_residuals(problem, parameters);
  const auto n = static_cast<double>(residuals.cols());
  ResidualCheck check;
  Eigen::Vector2d robust;
  for (int axis = 0; axis < 2; ++axis) {
    // Winsorised, so that outliers, which the loss already tames, do not pose as correlation.
    robust[axis] = std::max(robust_sigma_of(residuals.row(axis).transpose()), 1e-12);
    const Eigen::VectorXd tamed =
        residuals.row(axis).transpose().cwiseMin(3.0 * robust[axis]).cwiseMax(-3.0 * robust[axis]);
    check.quick_factor[axis] =
        std::max(1.0, quick_scatter(problem, residuals.row(axis).transpose()));
    const Judged judged =
        judge(frame_means(problem, tamed), n, robust[axis], lamp_correlation(problem, tamed));
    check.sigma_factor[axis] = judged.factor;
    check.misfit = std::max(check.misfit, judged.misfit);
    Eigen::VectorXd error(residuals.cols());
    for (Eigen::Index i = 0; i < residuals.cols(); ++i)
      error[i] = residuals(axis, i) * problem.lamps[static_cast<std::size_t>(i)].sigma[axis];
    check.scatter_px[axis] = robust_sigma_of(error) * focal_px;
  }
  judge_apart(problem, residuals, check);
  constexpr double kOutlier = 4.0;
  int outliers = 0;
  for (Eigen::Index i = 0; i < residuals.cols(); ++i)
    outliers += (residuals.col(i).cwiseAbs().array() > kOutlier * robust.array().max(1.0)).any();
  check.outlier_share = outliers / n;
  PathVector unrolled = parameters;
  unrolled[kRoll] = 0.0;
  const Tilt tilt = tilt_of(problem, bearing_residuals(problem, unrolled));
  check.tilt_rad = tilt.mean_rad;
  check.tilt_change_rad = tilt.change_rad;
  for (Uncertain* of : {&check.tilt_rad, &check.tilt_change_rad}) of->std *= check.quick_factor.y();
  return check;
}

}  // namespace vildar
