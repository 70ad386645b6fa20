#include "estimate/wander.h"

#include <array>
#include <cmath>

#include <Eigen/Cholesky>

namespace vildar {
namespace {

constexpr double kBefore_s = 1.0;

// How far accelerations wander, in m/s^2 over the root of a second, and how many vehicles in a
// hundred are taken to do so: most cruise, a few brake hard.
struct Wander {
  double mps2_per_root_s, share;
};
constexpr std::array<Wander, 5> kWanders{
    {{0.05, 0.4}, {0.4, 0.25}, {1.0, 0.2}, {2.5, 0.1}, {6.0, 0.05}}};

// The unknowns for one way of wandering, and ln of its evidence up to what all have in common.
struct Posterior {
  Eigen::VectorXd moved;
  Eigen::MatrixXd covariance;
  double log_evidence = -INFINITY;
};

Posterior posterior_of(WanderNormal normal, const Eigen::VectorXd& sizes, double size_std) {
  const Eigen::Index steps = sizes.size();
  auto& [information, gradient] = normal;
  const double prior = 1.0 / (size_std * size_std);
  information.diagonal().tail(steps).array() += prior;
  gradient.tail(steps) += prior * sizes;
  // Scaled, for the unknowns differ by many powers of ten.
  const Eigen::VectorXd scale = information.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LLT<Eigen::MatrixXd> root(scale.asDiagonal() * information * scale.asDiagonal());
  Posterior posterior;
  if (root.info() != Eigen::Success) return posterior;
  posterior.covariance = scale.asDiagonal() *
                         root.solve(Eigen::MatrixXd::Identity(scale.size(), scale.size())) *
                         scale.asDiagonal();
  posterior.moved = -posterior.covariance * gradient;
  posterior.log_evidence = -0.5 * (prior * sizes.squaredNorm() + gradient.dot(posterior.moved)) -
                           root.matrixLLT().diagonal().array().log().sum() +
                           scale.array().log().sum() -
                           static_cast<double>(steps) * std::log(size_std);
  return posterior;
}

}  // namespace

WanderNormal with_variance(const WanderNormal& normal, const AccelerationPrior& prior,
                           double variance) {
  const double more = 1.0 / variance - 1.0 / prior.variance;
  return {normal.information + more * prior.slopes * prior.slopes.transpose(),
          normal.gradient + more * prior.residual_mps2 * prior.slopes};
}

std::optional<WanderMixture> mix_wanders(const WanderNormal& normal, const AccelerationPrior& prior,
                                         const Eigen::VectorXd& sizes, double between_s,
                                         double mps2_per_size) {
  std::array<Posterior, kWanders.size()> posteriors;
  std::array<double, kWanders.size()> variances{}, size_stds{};
  double most = -INFINITY;
  for (std::size_t i = 0; i < kWanders.size(); ++i) {
    size_stds[i] = kWanders[i].mps2_per_root_s * std::sqrt(between_s) / mps2_per_size;
    // It wandered as much before, too.
    variances[i] =
        kAccelerationVariance_m2ps4 + std::pow(kWanders[i].mps2_per_root_s, 2) * kBefore_s;
    posteriors[i] = posterior_of(with_variance(normal, prior, variances[i]), sizes, size_stds[i]);
    posteriors[i].log_evidence +=
        std::log(kWanders[i].share) -
        0.5 * (prior.residual_mps2 * prior.residual_mps2 / variances[i] + std::log(variances[i]));
    most = std::max(most, posteriors[i].log_evidence);
  }
  if (!std::isfinite(most)) return std::nullopt;
  const Eigen::Index n = normal.gradient.size();
  WanderMixture mixture{Eigen::VectorXd::Zero(n), Eigen::MatrixXd::Zero(n, n), 0.0, 0.0};
  double sum = 0.0;
  for (std::size_t i = 0; i < posteriors.size(); ++i) {
    const auto& [moved, covariance, log_evidence] = posteriors[i];
    const double weight = std::exp(log_evidence - most);
    if (!(weight > 0.0)) continue;
    sum += weight;
    mixture.acceleration_variance += weight * variances[i];
    mixture.precision += weight / std::pow(size_stds[i], 2);
    mixture.moved += weight * moved;
    mixture.covariance += weight * (covariance + moved * moved.transpose());
  }
  mixture.acceleration_variance /= sum;
  mixture.precision /= sum;
  mixture.moved /= sum;
  mixture.covariance = mixture.covariance / sum - mixture.moved * mixture.moved.transpose();
  return mixture;
}

}  // namespace vildar
