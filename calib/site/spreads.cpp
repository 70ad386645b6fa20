#include "calib/site/spreads.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace vildar {
namespace {

constexpr int kMostSteps = 300;
constexpr double kSettled = 1e-3;  // relative change of a spread

double spread_weight_of(const Population& population, const Membership& member) {
  const double std = std::hypot(population.spread, member.extra_std);
  return 1.0 / (std * std);
}

// A pass with its path integrated out: distance of its values from the means is
// offset - follow * means, with covariance `covariance`.
struct Marginal {
  Eigen::VectorXd weights, offset;
  Eigen::MatrixXd follow, covariance;
};

Marginal marginal_of(const LinearPass& pass, const std::vector<Population>& populations) {
  const Eigen::Index count = pass.shared.size();
  Marginal marginal;
  marginal.weights.resize(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Membership& member = pass.members[static_cast<std::size_t>(i)];
    marginal.weights[i] = spread_weight_of(populations[member.population], member);
  }
  const Eigen::MatrixXd& by_path = pass.shared_by_path;
  const Eigen::MatrixXd precision =
      pass.information + by_path.transpose() * marginal.weights.asDiagonal() * by_path;
  const Eigen::VectorXd scale = precision.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LDLT<Eigen::MatrixXd> factor(scale.asDiagonal() * precision * scale.asDiagonal());
  const auto invert = [&](const Eigen::MatrixXd& right) {
    return Eigen::MatrixXd(scale.asDiagonal() * factor.solve(scale.asDiagonal() * right));
  };
  marginal.covariance = by_path * invert(by_path.transpose());
  const Eigen::MatrixXd pull = marginal.covariance * marginal.weights.asDiagonal();
  marginal.follow = Eigen::MatrixXd::Identity(count, count) - pull;
  marginal.offset = pass.shared - by_path * invert(pass.gradient) - pull * pass.shared;
  return marginal;
}

Learned posterior(std::span<const LinearPass> passes, const std::vector<Population>& populations) {
  const auto count = static_cast<Eigen::Index>(populations.size());
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(count, count);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Uncertain& mean = populations[static_cast<std::size_t>(i)].mean;
    information(i, i) = 1.0 / (mean.std * mean.std);
    right[i] = mean.mean * information(i, i);
  }
  std::vector<Marginal> marginals;
  for (const LinearPass& pass : passes) {
    marginals.push_back(marginal_of(pass, populations));
    const Marginal& marginal = marginals.back();
    const Eigen::MatrixXd share = marginal.weights.asDiagonal() * marginal.follow;
    const Eigen::VectorXd pulled = marginal.weights.cwiseProduct(marginal.offset);
    for (std::size_t i = 0; i < pass.members.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(pass.members[i].population);
      right[row] += pulled[static_cast<Eigen::Index>(i)];
      for (std::size_t j = 0; j < pass.members.size(); ++j)
        information(row, static_cast<Eigen::Index>(pass.members[j].population)) +=
            share(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
    }
  }
  const Eigen::VectorXd scale = information.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LDLT<Eigen::MatrixXd> factor(scale.asDiagonal() * information * scale.asDiagonal());
  Learned learned;
  learned.covariance = scale.asDiagonal() * factor.solve(Eigen::MatrixXd::Identity(count, count)) *
                       scale.asDiagonal();
  learned.means = learned.covariance * right;
  for (std::size_t p = 0; p < passes.size(); ++p) {
    const Marginal& marginal = marginals[p];
    std::vector<Eigen::Index> rows;
    for (const Membership& member : passes[p].members)
      rows.push_back(static_cast<Eigen::Index>(member.population));
    const Eigen::VectorXd means = learned.means(rows);
    const Eigen::MatrixXd of_means = learned.covariance(rows, rows);
    const Eigen::VectorXd apart = marginal.offset - marginal.follow * means;
    const Eigen::MatrixXd covariance =
        marginal.covariance + marginal.follow * of_means * marginal.follow.transpose();
    learned.squares.push_back(apart.cwiseAbs2() + covariance.diagonal());
    // Of a value's variance 1 / (1 / own + weight), so that of the pass alone.
    learned.own_variances.push_back(
        (marginal.covariance.diagonal().cwiseInverse() - marginal.weights)
            .cwiseMax(1e-3 * marginal.weights)
            .cwiseInverse());
  }
  return learned;
}

struct SquareSums {
  std::vector<double> sum, count;
};

SquareSums square_sums(std::span<const LinearPass> passes, const Learned& learned,
                       std::size_t populations) {
  SquareSums sums{std::vector<double>(populations), std::vector<double>(populations)};
  for (std::size_t p = 0; p < passes.size(); ++p)
    for (std::size_t i = 0; i < passes[p].members.size(); ++i) {
      const Membership& member = passes[p].members[i];
      if (member.extra_std > 0.0) continue;
      sums.sum[member.population] += learned.squares[p][static_cast<Eigen::Index>(i)];
      sums.count[member.population] += 1.0;
    }
  return sums;
}

double spread_from(const Population& population, double sum, double count) {
  const double likely = population.likely_spread;
  return std::sqrt((population.spread_weight * likely * likely + sum) /
                   (population.spread_weight + count));
}

}  // namespace

Learned learn_spreads(std::span<const LinearPass> passes, std::vector<Population>& populations) {
  for (int step = 0; step < kMostSteps; ++step) {
    const SquareSums sums = square_sums(passes, posterior(passes, populations), populations.size());
    double change = 0.0;
    for (std::size_t k = 0; k < populations.size(); ++k) {
      const double spread = spread_from(populations[k], sums.sum[k], sums.count[k]);
      change = std::max(change, std::abs(spread / populations[k].spread - 1.0));
      populations[k].spread = spread;
    }
    if (change < kSettled) break;
  }
  return posterior(passes, populations);
}

std::optional<std::size_t> stranger(std::span<const LinearPass> passes, const Learned& learned,
                                    const std::vector<Population>& populations) {
  // Five sigmas, where the sigma itself is that of a few dozen passes.
  constexpr double kFarthest2 = 25.0;
  const SquareSums sums = square_sums(passes, learned, populations.size());
  std::optional<std::size_t> farthest;
  double most = kFarthest2;
  for (std::size_t p = 0; p < passes.size(); ++p)
    for (std::size_t i = 0; i < passes[p].members.size(); ++i) {
      const Membership& member = passes[p].members[i];
      if (member.extra_std > 0.0) continue;
      const Population& population = populations[member.population];
      const double square = learned.squares[p][static_cast<Eigen::Index>(i)];
      const double others = spread_from(population, sums.sum[member.population] - square,
                                        sums.count[member.population] - 1.0);
      const double ratio =
          square / (others * others + learned.own_variances[p][static_cast<Eigen::Index>(i)]);
      if (ratio > most) {
        most = ratio;
        farthest = p;
      }
    }
  return farthest;
}

}  // namespace vildar
