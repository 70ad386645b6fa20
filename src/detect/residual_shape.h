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

  static constexpr int kRings = 6, kQuarters = 4;
  /// Number of a place about a lamp, `offset_px` from it and in so many rings of what is used
  /// there.
  static int place_of(int lamp, const Eigen::Vector2f& offset_px, float rings) {
    const int ring = std::min(static_cast<int>(rings), kRings - 1);
    const int quarter = (offset_px.x() + offset_px.y() > 0.0F ? 1 : 0) +
                        (offset_px.x() - offset_px.y() > 0.0F ? 2 : 0);
    return kQuarters * (kRings * lamp + ring) + quarter;
  }

  /// A pixel's residual over its sigma, in a place of a lamp; in the one after the last it does not
  /// count. `noise_share` of its variance is its own, the rest is common to pixels that lie
  /// together.
  void add(int place, float residual, float noise_share) {
    const std::size_t at = kTurns * static_cast<std::size_t>(place) + turn_;
    count_[at] += 1.0F;
    sum_[at] += residual;
    noise_[at] += noise_share;
    square_[at] += residual * residual;
    turn_ = (turn_ + 1) % kTurns;
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
  /// Neighbours mostly lie in one place: sums that take turns do not wait for one another.
  static constexpr std::size_t kTurns = 4;
  std::size_t lamps_;
  double correlated_px_;
  // So many of each quarter of each ring of each lamp, and of what does not count.
  std::vector<float> count_, sum_, noise_, square_;
  std::size_t turn_ = 0;
};

}  // namespace vildar
