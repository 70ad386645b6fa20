#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace vildar {

/// Sums what a fit leaves over by rings and quarters about each lamp, and says whether it has a
/// shape: noise has none, whatever its size.
class ResidualShape {
 public:
  /// Pixels err together by patches of `correlated_px` on average.
  explicit ResidualShape(std::size_t lamps, double correlated_px = 1.0);

  /// A pixel's residual over its sigma, `offset_px` from the lamp next to it, at `ring` of what is
  /// used about the lamp, 0 to 1. `noise_share` of its variance is its own, the rest is common to
  /// pixels that lie together.
  void add(std::size_t lamp, const Eigen::Vector2f& offset_px, float ring, float residual,
           float noise_share) {
    const std::size_t in =
        kRings * lamp +
        std::min(static_cast<std::size_t>(ring * static_cast<float>(kRings)), kRings - 1);
    const std::size_t quarter = (offset_px.x() + offset_px.y() > 0.0F ? 1 : 0) +
                                (offset_px.x() - offset_px.y() > 0.0F ? 2 : 0);
    const auto one = static_cast<double>(residual);
    square_ += one * one;
    Sum& sum = places_[kQuarters * in + quarter];
    sum.n += 1.0;
    sum.sum += one;
    sum.noise += static_cast<double>(noise_share);
  }

  struct Verdict {
    double chi2_per_dof = 0.0;
    double shape_per_dof = 0.0;    ///< mean square over rings and quarters
    double shape = 0.0;            ///< sum of those squares
    bool shaped = false;           ///< more of it than chance gives in one case of a hundred
    bool quarters_differ = false;  ///< by more than chance makes them
    /// Alike in all quarters, beyond what the quarters' differences explain: the lamp's own light
    /// is not as it was taken for, rather than what lies about it.
    bool round = false;
  };
  /// With so many parameters fitted to each lamp, and terms of a background.
  Verdict verdict(double per_lamp, double background_terms) const;

 private:
  static constexpr std::size_t kRings = 6, kQuarters = 4;
  struct Sum {
    double n = 0.0, sum = 0.0, noise = 0.0;
  };
  std::size_t lamps_;
  double correlated_px_;
  std::vector<Sum> places_;  // quarters of rings of lamps
  double square_ = 0.0;
};

}  // namespace vildar
