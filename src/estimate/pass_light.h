#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "estimate/joint_cost.h"
#include "estimate/power_method.h"
#include "estimate/series_blocks.h"
#include "estimate/solve.h"

namespace vildar {

/// By what ln of the light of lamps unlike the law differs: cos(k pi a / 0.45), k from 1 to 6, of
/// the azimuth a off the vehicle's path, a^2, and the elevation.
inline constexpr std::size_t kBeamShapes = kBeamWaves + 2;
using BeamShapes = std::array<double, kBeamShapes>;

/// Standard deviation of each one's coefficient where that of the first cosine is `ripple_nat`.
/// That of a^2 (per rad^2) and of the elevation (per rad) is four times as large: at a nat about
/// what headlamps differ by.
double beam_shape_std(double ripple_nat, std::size_t shape);
/// a^2 and the elevation.
constexpr bool is_smooth(std::size_t shape) { return shape >= kBeamWaves; }

/// All that shapes the light of one pass. Unknowns but ln of the speed's and the distance's change
/// are in units of their prior's standard deviation.
enum PassUnknown : int {
  kLogSpeed,
  kLogAlong,
  kSpeedingUp,
  kGamma,
  kAside,
  kHeight,
  kRadius,
  kStraightLength,
  kGain,
  kDark,   ///< of the background
  kShape,  ///< first of the shapes of the beam
  kPassUnknowns = kShape + static_cast<int>(kBeamShapes),
};
inline constexpr int kPassPriors = kPassUnknowns - kSpeedingUp;

/// The shapes at the given times of a motion; where K was fitted to the light itself, less what
/// went into it.
std::vector<BeamShapes> beam_shapes(const PowerCase& known, const PassMotion& motion,
                                    std::span<const double> time_s);

/// The light of a vehicle whose lamps may be unlike the law, with all that `known` leaves open, the
/// background and a constant acceleration of 0 +- 1.5 m/s^2. Blocks of 10 ms, one percent of each
/// unmodelled.
class PassLight {
 public:
  /// `known` outlives this. Unknowns of nought are `motion` without its acceleration, the law and
  /// what is known on average.
  PassLight(const PowerSeries& series, const PowerCase& known, const PassMotion& motion);

  std::size_t blocks() const { return blocks_.time_s.size(); }

  /// Whitened errors of the blocks, then the priors from the acceleration on. `ripple_nat`: as in
  /// beam_shape_std. Nothing where the vehicle is not ahead throughout.
  std::optional<Residuals> residuals(const Eigen::VectorXd& z, double ripple_nat,
                                     bool with_slopes) const;

  PassMotion motion_of(const Eigen::VectorXd& z) const;
  /// Unknowns of nought but for the acceleration, which is that of `motion`.
  static Eigen::VectorXd nearest_to(const PassMotion& motion);

 private:
  // Without background, of each block.
  struct Light;

  PowerCase known_of(const Eigen::VectorXd& z) const;
  std::optional<Light> light_of(const Eigen::VectorXd& z, const PassMotion& motion,
                                double ripple_nat) const;
  void add_log_slopes_of_places(const Eigen::VectorXd& z, double ripple_nat, const Light& light,
                                Eigen::MatrixXd& slopes) const;

  SeriesBlocks blocks_;
  const PowerCase& known_;
  PassMotion motion_;
  double ahead_m_;  ///< of the receiver, at the reference
  double background_std_w_;
};

}  // namespace vildar
