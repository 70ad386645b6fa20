#pragma once

#include <array>

#include <ceres/sized_cost_function.h>

#include "core/quantity.h"
#include "estimate/geometry_cost.h"

namespace vildar {

/// Unknowns that the photodiodes share.
enum LightParameter : int {
  kLogGain,   ///< ln of gain over the power unit, less gamma ln X: what remains seen if all lengths
              ///< scale
  kExponent,  ///< gamma
  kTimeShift,  ///< s, later than the mean time offset
  kBeamWidth,  ///< of azimuth squared
  kBeamTilt,   ///< of elevation
  kBeamWave,   ///< first of the cosines
  kBeamWaves = 6,
  kLightParameters = kBeamWave + kBeamWaves,
};

/// Unknowns of one photodiode.
enum ReceiverParameter : int {
  kBackground,  ///< in power units
  kDrift,       ///< of the background, power units per second
  kLogRatio,    ///< ln of its gain over the first one's
  kAhead,       ///< m, its place along the road beyond the site's
  kReceiverParameters,
};

/// Azimuth at which the cosines have gone through half a turn; the model is used up to here.
inline constexpr double kBeamEdge_rad = 0.45;

/// Prior of a beam coefficient about nought, loose enough for any headlamp: e-fold at 0.3 rad, half
/// an e-fold of ripple.
constexpr double beam_prior_std(int parameter) {
  if (parameter == kBeamWidth) return 12.0;
  if (parameter == kBeamTilt) return 10.0;
  return 0.5 / (parameter - kBeamWave + 1);
}

struct LightSetting {
  const GeometryProblem* problem = nullptr;
  /// kLogScale at which photodiodes stand where the site has them. By another they stand off the
  /// camera by as many times more: light of no photodiode tells lengths by where that stands, for
  /// any beam that does not follow the model to a thousandth looks like another length.
  double log_scale = 0.0;
  double log_gain = 0.0, log_gain_std = 0.0;  ///< prior of ln (gain over power unit); std 0: none
  double exponent = 2.0, exponent_std = 0.0;  ///< std 0: fixed
  double cosine_exponent = 0.0;
  double time_shift_s = 0.0, time_shift_std_s = 0.0;  ///< std 0: fixed
  double power_unit_w = 1.0;
};

struct Receiver {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  double log_ratio = 0.0, log_ratio_std = 0.0;
  double ahead_std_m = 0.0;  ///< of its place along the road from the first one's; 0: known
  double middle_s = 0.0;     ///< time at which background and drift are referred
};

/// How ln of the received power follows its unknowns.
struct PowerGradient {
  PathVector path;
  std::array<double, kLightParameters> light{};
  double moved = 0.0;  ///< by the photodiode's place along the road
};

/// ln of the received power over the power unit, without background, `tau_s` after the path's
/// reference time; a pair of lamps shines in halves, each from its own place. `moved_m`: of the
/// photodiode along the road. False where a lamp is not ahead of the photodiode.
bool log_power(const double* path, const double* light, const LightSetting& setting,
               const Eigen::Vector3d& receiver_m, double moved_m, double tau_s, double& value,
               PowerGradient* gradient = nullptr);

/// A block's mean in power units, and what the model needs to know of it.
struct LitBlock {
  double time_s = 0.0;
  double power = 0.0;
  double noise = 0.0;  ///< sigma of white noise
  double light = 0.0;  ///< without background, not below zero
  double bulge = 1.0;  ///< mean of the light over the block, over that at its middle
  double sigma = 0.0;  ///< as used: noise, what the model leaves out, and correlation
};

/// Whitened error of one block's mean, by path, light and its photodiode's own unknowns.
class BlockResidual
    : public ceres::SizedCostFunction<1, kPathParameters, kLightParameters, kReceiverParameters> {
 public:
  /// All three outlive this.
  BlockResidual(const LightSetting& setting, const Receiver& receiver, const LitBlock& block)
      : setting_(setting), receiver_(receiver), block_(block) {}

  /// False where the vehicle is not ahead of the photodiode.
  bool Evaluate(double const* const* unknowns, double* residual, double** jacobians) const override;

 private:
  const LightSetting& setting_;
  const Receiver& receiver_;
  const LitBlock& block_;
};

}  // namespace vildar
