#include "estimate/power_least_squares.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

namespace vildar {

PowerLeastSquares::PowerLeastSquares(const PowerSamples& samples, const PowerKnowledge& known,
                                     const PowerSetting& setting, double huber_sigma)
    : samples_(samples),
      known_(known),
      setting_(setting),
      huber_sigma_(huber_sigma),
      free_(free_parameters(known, setting)),
      pull_(samples.time_s.size()),
      weight_(samples.time_s.size()) {}

PowerCost PowerLeastSquares::cost_at(const PowerVector& value) {
  const auto n = static_cast<Eigen::Index>(free_.size());
  const std::size_t samples = samples_.time_s.size();
  PowerCost result{0.0, Eigen::VectorXd::Zero(n), Eigen::MatrixXd::Zero(n, n)};
  curve_.differentiate(value, setting_, samples_.time_s, free_);
  const std::span<const double> power = curve_.power_w();
  using Samples = Eigen::Map<const Eigen::VectorXd>;
  const auto count = static_cast<Eigen::Index>(samples);
  const Samples pull(pull_.data(), count), weight(weight_.data(), count);
  double cost = 0.0;
  if (std::isinf(huber_sigma_)) {
    weight_ = samples_.weight;
    for (std::size_t i = 0; i < samples; ++i)
      pull_[i] = weight_[i] * (samples_.power_w[i] - power[i]);
    cost = 0.5 * pull.dot(Samples(samples_.power_w.data(), count) - Samples(power.data(), count));
  } else {
    for (std::size_t i = 0; i < samples; ++i) {
      const double error = samples_.power_w[i] - power[i];
      const double whitened = std::abs(error) * std::sqrt(samples_.weight[i]);
      const bool far = whitened > huber_sigma_;
      weight_[i] = samples_.weight[i] * (far ? huber_sigma_ / whitened : 1.0);
      pull_[i] = weight_[i] * error;
      cost += far ? huber_sigma_ * (whitened - 0.5 * huber_sigma_) : 0.5 * whitened * whitened;
    }
  }
  const auto column = [&](Eigen::Index index) {
    return Samples(curve_.column(static_cast<std::size_t>(index)).data(), count);
  };
  for (Eigen::Index a = 0; a < n; ++a) {
    result.gradient[a] = pull.dot(column(a));
    for (Eigen::Index b = 0; b <= a; ++b)
      result.information(a, b) = result.information(b, a) =
          weight.dot(column(a).cwiseProduct(column(b)));
  }
  for (Eigen::Index a = 0; a < n; ++a) {
    const PowerParameter p = free_[static_cast<std::size_t>(a)];
    if (!known_[p]) continue;
    const double off = (known_[p]->mean - value[p]) / known_[p]->std;
    cost += 0.5 * off * off;
    result.gradient[a] += off / known_[p]->std;
    result.information(a, a) += 1.0 / (known_[p]->std * known_[p]->std);
  }
  result.cost = cost;
  return result;
}

std::vector<double> PowerLeastSquares::residuals() const {
  std::vector<double> whitened(samples_.time_s.size());
  for (std::size_t i = 0; i < whitened.size(); ++i)
    whitened[i] = (samples_.power_w[i] - curve_.power_w()[i]) * std::sqrt(samples_.weight[i]);
  return whitened;
}

// Where K is not exact, the samples hold the scale (all lengths times c, K times c^gamma) weakly or
// not at all, and the valley of good fits runs along that curve, not along its tangent.
PowerVector PowerLeastSquares::moved(const PowerVector& value, const Eigen::VectorXd& step) const {
  PowerVector delta = PowerVector::Zero();
  for (std::size_t a = 0; a < free_.size(); ++a)
    delta[free_[a]] = step[static_cast<Eigen::Index>(a)];
  const bool gain_free = std::find(free_.begin(), free_.end(), kPowerLogGain) != free_.end();
  if (!gain_free || value[kPowerSpeed] == 0.0) return value + delta;
  const double growth = delta[kPowerSpeed] / value[kPowerSpeed];
  if (!(std::abs(growth) < 1.0)) return value + delta;
  PowerVector next = value;
  for (const PowerParameter p : free_) {
    if (p == kPowerLogGain)
      next[p] += delta[p] + delta[kPowerExponent] * growth;
    else if (p == kPowerExponent)
      next[p] += delta[p];
    else
      next[p] = std::exp(growth) * (value[p] + delta[p] - growth * value[p]);
  }
  return next;
}

PowerLeastSquares::Minimum PowerLeastSquares::minimise(const PowerVector& start,
                                                       int most_iterations) {
  // The decrement is the square of the next step in sigmas: stop at a thousandth of a sigma.
  constexpr double kSmallDecrement = 1e-6;
  constexpr double kMostDamped = 1e12;
  Minimum best{start, cost_at(start), 0, false};
  double damping = 0.0;
  while (best.iterations < most_iterations && !best.converged) {
    ++best.iterations;
    Eigen::MatrixXd damped = best.at.information;
    damped.diagonal() *= 1.0 + damping;
    const Eigen::VectorXd step = damped.ldlt().solve(best.at.gradient);
    const double decrement = step.dot(best.at.gradient);
    if (step.allFinite() && decrement >= 0.0) {
      const PowerVector next = moved(best.value, step);
      const bool in_domain =
          next[kPowerExponent] > 0.0 && (!setting_.curved || next[kPowerRadius] > 0.0);
      const bool last = damping < 1e-6 && decrement < kSmallDecrement;
      if (in_domain && last) {
        best.value = next;
        best.converged = true;
        break;
      }
      if (in_domain) {
        PowerCost at = cost_at(next);
        if (std::isfinite(at.cost) && at.cost <= best.at.cost) {
          best.value = next;
          best.at = std::move(at);
          damping = damping < 1e-6 ? 0.0 : 0.1 * damping;
          continue;
        }
      }
      // At the rounding floor no step improves any more.
      if (decrement < 1e-3 * kSmallDecrement + 1e-13 * best.at.cost) best.converged = true;
    }
    damping = damping == 0.0 ? 1e-3 : 10.0 * damping;
    if (damping > kMostDamped) break;
  }
  return best;
}

}  // namespace vildar
