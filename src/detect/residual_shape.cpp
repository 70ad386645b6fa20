#include "detect/residual_shape.h"

#include <algorithm>
#include <cmath>

namespace vildar {
namespace {

constexpr double kLeastPixels = 4.0;  // of a quarter of a ring
constexpr double kOnceInHundred = 2.326, kOnceInTwoHundred = 2.576;

/// Standard normal equivalent of a ratio of two mean squares with so many degrees of freedom
/// (Paulson 1942).
double normal_of_ratio(double ratio, double above, double below) {
  const double root = std::cbrt(ratio), a = 2.0 / (9.0 * above), b = 2.0 / (9.0 * below);
  return ((1.0 - b) * root - (1.0 - a)) / std::sqrt(b * root * root + a);
}

}  // namespace

ResidualShape::ResidualShape(std::size_t lamps, double correlated_px)
    : lamps_(lamps),
      correlated_px_(correlated_px),
      count_(kTurns * (kRings * kQuarters * lamps + 1)),
      sum_(count_),
      noise_(count_),
      square_(count_) {}

ResidualShape::Verdict ResidualShape::verdict(double per_lamp, double background_terms) const {
  struct Sum {
    double n = 0.0, sum = 0.0, noise = 0.0;
  };
  using Sums = std::vector<Sum>;
  Sums quarters(kRings * kQuarters * lamps_), whole_rings(kRings * lamps_);
  double used = 0.0, square = 0.0;
  for (std::size_t at = 0; at < kTurns * quarters.size(); ++at) {
    for (Sum* one : {&quarters[at / kTurns], &whole_rings[at / kTurns / kQuarters]}) {
      one->n += static_cast<double>(count_[at]);
      one->sum += static_cast<double>(sum_[at]);
      one->noise += static_cast<double>(noise_[at]);
    }
    used += static_cast<double>(count_[at]);
    square += static_cast<double>(square_[at]);
  }
  double places = 0.0, between = 0.0, rings = 0.0, between_rings = 0.0;
  const auto add_up = [](const Sums& sums, double least, double& count, double& squares) {
    for (const Sum& one : sums) {
      if (one.n < least) continue;
      count += 1.0;
      squares += one.sum * one.sum / one.n;
    }
  };
  add_up(quarters, kLeastPixels, places, between);
  add_up(whole_rings, kQuarters * kLeastPixels, rings, between_rings);
  const auto lamps = static_cast<double>(lamps_);
  const double fitted = per_lamp * lamps + background_terms;
  const double within_dof = std::max(used - places, 1.0);
  const double scatter = correlated_px_ * std::max((square - between) / within_dof, 1e-12);
  // Against what the scatter makes of as many pixels, and what they have in common.
  const auto shaped = [&](const Sums& sums, double least, double dof) {
    double expected = 0.0;
    for (const Sum& one : sums)
      if (one.n >= least)
        expected += one.sum * one.sum / one.n / (scatter + 1.0 - one.noise / one.n);
    return normal_of_ratio(expected / dof, dof, within_dof) > kOnceInTwoHundred;
  };

  Verdict verdict;
  const double dof = std::max(places - fitted, 1.0);
  // Of a lamp's parameters two, its centre, and of the background's all but one turn with the
  // angle.
  const double round_dof = std::max(rings - (per_lamp - 2.0) * lamps - 1.0, 1.0);
  const double uneven_dof = std::max(places - rings - 2.0 * lamps - background_terms + 1.0, 1.0);
  verdict.chi2_per_dof = square / std::max(used - fitted, 1.0);
  verdict.shape = between;
  verdict.shape_per_dof = between / dof;
  // Wings that are not as they were taken for are alike in all quarters: rings tell them sooner.
  verdict.shaped = shaped(quarters, kLeastPixels, dof) ||
                   shaped(whole_rings, kQuarters * kLeastPixels, round_dof);
  // Quarters that differ no more than chance makes them say nothing of what lies about the lamp.
  const double uneven = (between - between_rings) / uneven_dof;
  verdict.quarters_differ =
      normal_of_ratio(uneven / scatter, uneven_dof, within_dof) > kOnceInHundred;
  verdict.round =
      normal_of_ratio(between_rings / round_dof / (verdict.quarters_differ ? uneven : scatter),
                      round_dof,
                      verdict.quarters_differ ? uneven_dof : within_dof) > kOnceInHundred;
  return verdict;
}

}  // namespace vildar
