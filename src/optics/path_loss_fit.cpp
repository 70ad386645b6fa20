#include "optics/path_loss_fit.h"

#include <cmath>
#include <stdexcept>

#include <Eigen/Dense>

#include "optics/channel.h"

namespace vildar {
namespace {

using Eigen::ArrayXd;

double rms_db(const ArrayXd& log_distance, const ArrayXd& log_power, double log_gain,
              double gamma) {
  const ArrayXd error = log_power - log_gain + gamma * log_distance;
  return 10.0 / std::log(10.0) * std::sqrt(error.square().mean());
}

}  // namespace

Outcome<PathLossFit> fit_path_loss(std::span<const double> distance_m,
                                   std::span<const double> power_w, FitDomain domain) {
  if (distance_m.size() != power_w.size())
    throw std::invalid_argument("fit_path_loss: as many distances as powers are needed");
  const auto n = static_cast<Eigen::Index>(distance_m.size());
  if (n < 2) return Miss::too_few_samples;
  const Eigen::Map<const ArrayXd> distance(distance_m.data(), n), power(power_w.data(), n);
  if (!(distance > 0.0).all()) throw std::domain_error("fit_path_loss: distances must be positive");
  if (!((power > 0.0).all() && power.isFinite().all())) return Miss::below_noise;

  const ArrayXd x = distance.log(), y = power.log();
  const ArrayXd dx = x - x.mean();
  const double spread = dx.square().sum();
  if (!(spread > 1e-20)) return Miss::no_time_spread;
  double gamma = -(dx * y).sum() / spread;
  double log_gain = y.mean() + gamma * x.mean();
  PathLossFit fit;
  if (domain == FitDomain::linear) {
    // Gauss-Newton in (ln K, gamma) from the decibel solution, halving steps that do not improve.
    const auto model = [&](double log_k, double g) -> ArrayXd { return (log_k - g * x).exp(); };
    double cost = (power - model(log_gain, gamma)).square().sum();
    const double scale = power.square().sum();
    bool converged = false;
    while (!converged && fit.iterations < 100) {
      ++fit.iterations;
      const ArrayXd p = model(log_gain, gamma);
      Eigen::MatrixX2d jacobian(n, 2);
      jacobian.col(0) = p;
      jacobian.col(1) = -x * p;
      Eigen::Vector2d step = jacobian.colPivHouseholderQr().solve((power - p).matrix());
      double next = 0.0;
      for (int halving = 0; halving < 40; ++halving, step *= 0.5) {
        next = (power - model(log_gain + step[0], gamma + step[1])).square().sum();
        if (next <= cost) break;
      }
      if (next <= cost) {
        log_gain += step[0];
        gamma += step[1];
      }
      converged = !(cost - next > 1e-15 * scale) && step.cwiseAbs().maxCoeff() < 1e-7;
      if (next > cost) converged = true;  // at the rounding floor
      cost = std::min(cost, next);
    }
    if (!converged) return Miss::not_converged;
  }
  fit.gain_w = std::exp(log_gain);
  fit.path_loss_exponent = gamma;
  fit.rms_db = rms_db(x, y, log_gain, gamma);
  return fit;
}

}  // namespace vildar
