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
    : lamps_(lamps), correlated_px_(correlated_px), places_(kRings * kQuarters * lamps) {}

ResidualShape::Verdict ResidualShape::verdict(double per_lamp, double background_terms) const {
  std::vector<Sum> whole_rings(kRings * lamps_);
  double used = 0.0;
  for (std::size_t place = 0; place < places_.size(); ++place) {
    const Sum& part = places_[place];
    Sum& ring = whole_rings[place / kQuarters];
    ring.n += part.n;
    ring.sum += part.sum;
    ring.noise += part.noise;
    used += part.n;
  }
  double places = 0.0, between = 0.0, rings = 0.0, between_rings = 0.0;
  const auto add_up = [](const std::vector<Sum>& sums, double least, double& count,
                         double& square) {
    for (const Sum& one : sums) {
      if (one.n < least) continue;
      count += 1.0;
      square += one.sum * one.sum / one.n;
    }
  };
  add_up(places_, kLeastPixels, places, between);
  add_up(whole_rings, kQuarters * kLeastPixels, rings, between_rings);
  const auto lamps = static_cast<double>(lamps_);
  const double fitted = per_lamp * lamps + background_terms;
  const double within_dof = std::max(used - places, 1.0);
  const double scatter = correlated_px_ * std::max((square_ - between) / within_dof, 1e-12);
  // Against what the scatter makes of as many pixels, and what they have in common.
  const auto shaped = [&](const std::vector<Sum>& sums, double least, double dof) {
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
  verdict.chi2_per_dof = square_ / std::max(used - fitted, 1.0);
  verdict.shape = between;
  verdict.shape_per_dof = between / dof;
  // Wings that are not as they were taken for are alike in all quarters: rings tell them sooner.
  verdict.shaped = shaped(places_, kLeastPixels, dof) ||
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
