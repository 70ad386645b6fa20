#include "calib/site/stated_sigmas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace vildar {
namespace {

using Set = std::vector<Eigen::Index>;

const Population& at(const std::vector<Population>& populations, Eigen::Index index) {
  return populations[static_cast<std::size_t>(index)];
}

// What a set of lengths tells of ln scale where only spreads count, and the variance that the
// means' errors add to an estimate that trusts it; with those of the focal length, where `lens` is
// its index.
struct ScaleOfSet {
  double information = 0.0;
  double common_variance = 0.0;
};

ScaleOfSet scale_of(const Set& set, const std::vector<Population>& populations,
                    const Eigen::MatrixXd& covariance,
                    std::optional<Eigen::Index> lens = std::nullopt) {
  Eigen::VectorXd pull(static_cast<Eigen::Index>(set.size()));
  for (std::size_t i = 0; i < set.size(); ++i) {
    const double spread = at(populations, set[i]).spread;
    pull[static_cast<Eigen::Index>(i)] = 1.0 / (spread * spread);
  }
  const double information = pull.sum();
  pull /= information;
  double variance = pull.dot(covariance(set, set) * pull);
  if (lens) variance += 2.0 * pull.dot(covariance(set, *lens)) + covariance(*lens, *lens);
  return {information, variance};
}

// All sets of one length of each sort that one vehicle may have.
std::vector<Set> sets_of(const std::vector<Population>& populations) {
  std::array<Set, 3> sorts;
  for (std::size_t k = 0; k < populations.size(); ++k)
    if (is_length(populations[k].kind))
      sorts[static_cast<std::size_t>(populations[k].kind)].push_back(static_cast<Eigen::Index>(k));
  std::vector<Set> sets{{}};
  for (const Set& sort : sorts) {
    const std::size_t before = sets.size();
    for (std::size_t s = 0; s < before; ++s)
      for (const Eigen::Index index : sort) {
        if (!sets[s].empty() &&
            at(populations, sets[s].front()).tail != at(populations, index).tail)
          continue;
        sets.push_back(sets[s]);
        sets.back().push_back(index);
      }
  }
  sets.erase(sets.begin());
  return sets;
}

}  // namespace

std::vector<double> stated_stds(const std::vector<Population>& populations,
                                const Learned& learned) {
  std::vector<double> widening(populations.size(), 1.0);
  for (std::size_t k = 0; k < populations.size(); ++k) {
    const double spread = populations[k].spread;
    const auto own = static_cast<Eigen::Index>(k);
    widening[k] = 1.0 + learned.covariance(own, own) / (spread * spread);
  }
  for (const Set& set : sets_of(populations)) {
    const ScaleOfSet scale = scale_of(set, populations, learned.covariance);
    for (const Eigen::Index index : set) {
      double& own = widening[static_cast<std::size_t>(index)];
      own = std::max(own, 1.0 + scale.information * scale.common_variance);
    }
  }
  std::vector<double> stds;
  for (std::size_t k = 0; k < populations.size(); ++k)
    stds.push_back(populations[k].per_step() * populations[k].spread * std::sqrt(widening[k]));
  return stds;
}

double common_scale_std(const std::vector<Population>& populations,
                        const Eigen::MatrixXd& covariance) {
  // What a length spans in the picture grows with the focal length, and so does the scale.
  const auto focal = std::ranges::find(populations, Shared::focal, &Population::kind);
  std::optional<Eigen::Index> lens;
  if (focal != populations.end()) lens = focal - populations.begin();
  ScaleOfSet strongest;
  for (const Set& set : sets_of(populations)) {
    const ScaleOfSet scale = scale_of(set, populations, covariance, lens);
    if (scale.information > strongest.information) strongest = scale;
  }
  return std::sqrt(strongest.common_variance);
}

}  // namespace vildar
