#include "estimate/line_fit.h"

#include <cmath>

#include <Eigen/Core>

namespace vildar {

Outcome<LineFit> fit_line(std::span<const double> time_s, std::span<const double> values) {
  const auto n = static_cast<Eigen::Index>(time_s.size());
  if (n < 3) return Miss::too_few_samples;
  const Eigen::Map<const Eigen::ArrayXd> t_s(time_s.data(), n), y(values.data(), n);
  const double mean_s = t_s.mean(), mean_y = y.mean();
  // Centred sums: the same solution as the normal equations of [t, 1], without their cancellation.
  const auto dt_s = t_s - mean_s;
  const auto dy = y - mean_y;
  const double spread_s2 = dt_s.square().sum();
  const double widest_s = t_s.abs().maxCoeff();
  if (!(spread_s2 > 1e-24 * (1.0 + widest_s * widest_s))) return Miss::no_time_spread;

  LineFit fit;
  fit.samples = n;
  fit.slope = (dt_s * dy).sum() / spread_s2;
  fit.intercept = mean_y - fit.slope * mean_s;
  const Eigen::ArrayXd residual = dy - fit.slope * dt_s;
  const double sum2 = residual.square().sum();
  fit.residual_sigma = std::sqrt(sum2 / static_cast<double>(n - 2));
  fit.slope_sigma = fit.residual_sigma / std::sqrt(spread_s2);
  if (sum2 > 0.0) fit.lag1_correlation = (residual.head(n - 1) * residual.tail(n - 1)).sum() / sum2;
  return fit;
}

}  // namespace vildar
