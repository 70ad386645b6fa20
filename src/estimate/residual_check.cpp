#include "estimate/residual_check.h"

#include <algorithm>
#include <cmath>

namespace vildar {
namespace {

constexpr double kSigmaPerMad = 1.4826;

double median_abs(const Eigen::VectorXd& values) {
  std::vector<double> sorted(values.data(), values.data() + values.size());
  for (double& value : sorted) value = std::abs(value);
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return *middle;
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

// Variance factor for fitting a slow function to these residuals as if they were independent.
double correlation_factor(const GeometryProblem& problem, const Eigen::VectorXd& residual) {
  std::vector<double> frame_mean;
  double lamp_product = 0.0, lamp_square = 0.0;
  int lamp_pairs = 0;
  for (std::size_t i = 0; i < problem.lamps.size(); ++i) {
    const double r = residual[static_cast<Eigen::Index>(i)];
    const bool paired =
        i + 1 < problem.lamps.size() && problem.lamps[i + 1].sighting == problem.lamps[i].sighting;
    if (!paired) {
      frame_mean.push_back(r);
      continue;
    }
    const double other = residual[static_cast<Eigen::Index>(++i)];
    frame_mean.push_back(0.5 * (r + other));
    lamp_product += r * other;
    lamp_square += 0.5 * (r * r + other * other);
    ++lamp_pairs;
  }
  double lag_product = 0.0, lag_square = 0.0;
  for (std::size_t i = 0; i + 1 < frame_mean.size(); ++i) {
    lag_product += frame_mean[i] * frame_mean[i + 1];
    lag_square += 0.5 * (frame_mean[i] * frame_mean[i] + frame_mean[i + 1] * frame_mean[i + 1]);
  }
  const double lamps = correlation(lamp_product, lamp_square, lamp_pairs);
  const double lag = correlation(lag_product, lag_square, static_cast<int>(frame_mean.size()) - 1);
  return (1.0 + lamps) * (1.0 + lag) / (1.0 - lag);
}

}  // namespace

ResidualCheck check_residuals(const GeometryProblem& problem, const PathVector& parameters,
                              double focal_px) {
  Eigen::Matrix2Xd residuals = bearing_residuals(problem, parameters);
  const auto n = static_cast<double>(residuals.cols());
  ResidualCheck check;
  Eigen::Vector2d robust;
  for (int axis = 0; axis < 2; ++axis) {
    // Winsorised, so that outliers, which the loss already tames, do not pose as correlation.
    robust[axis] = std::max(kSigmaPerMad * median_abs(residuals.row(axis).transpose()), 1e-12);
    const Eigen::VectorXd tamed =
        residuals.row(axis).transpose().cwiseMin(3.0 * robust[axis]).cwiseMax(-3.0 * robust[axis]);
    const double correlated = correlation_factor(problem, tamed);
    const double freedom = std::max(0.25 * n, n - kUnknownsPerAxis * correlated);
    const double scatter = robust[axis] * std::sqrt(n / freedom);
    check.sigma_factor[axis] = std::max(1.0, scatter) * std::sqrt(correlated);
    Eigen::VectorXd error(residuals.cols());
    for (Eigen::Index i = 0; i < residuals.cols(); ++i)
      error[i] = residuals(axis, i) * problem.lamps[static_cast<std::size_t>(i)].sigma[axis];
    check.scatter_px[axis] = kSigmaPerMad * median_abs(error) * focal_px;
  }
  constexpr double kOutlier = 4.0;
  int outliers = 0;
  for (Eigen::Index i = 0; i < residuals.cols(); ++i)
    outliers += (residuals.col(i).cwiseAbs().array() > kOutlier * robust.array().max(1.0)).any();
  check.outlier_share = outliers / n;
  return check;
}

}  // namespace vildar
