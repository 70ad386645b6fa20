#pragma once

#include <array>
#include <cmath>

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

struct LightSetting {
  const GeometryProblem* problem = nullptr;
  double log_gain = 0.0, log_gain_std = 0.0;  ///< prior of ln (gain over power unit); std 0: none
  double exponent = 2.0, exponent_std = 0.0;  ///< std 0: fixed
  double cosine_exponent = 0.0;
  double time_shift_std_s = 0.0;  ///< 0: fixed
  double power_unit_w = 1.0;
};

struct Receiver {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  double log_ratio = 0.0, log_ratio_std = 0.0;
  double ahead_std_m = 0.0;  ///< of its place along the road from the first one's; 0: known
  double middle_s = 0.0;     ///< time at which background and drift are referred
};

/// How a photodiode sees the vehicle, ahead of it; all that the light's unknowns have no part in.
template <class T>
struct LightPath {
  T log_distance;  ///< ln of metres
  T azimuth_rad, elevation_rad;
  T log_cosine;  ///< of the angle off the road's direction
};

/// False where the vehicle is not ahead of the photodiode.
template <class T>
bool light_path(const T* path, const GeometryProblem& problem, const Eigen::Vector3d& receiver_m,
                const T& moved_m, const T& tau_s, LightPath<T>& seen) {
  using std::atan2;
  using std::exp;
  using std::log;
  using std::sqrt;
  const T scale_m = exp(path[kLogScale]);
  const PathPoint<T> place = vehicle_point(path, problem.setting, tau_s);
  const T ahead_m = place.x_m - receiver_m.x() - moved_m;
  const T across_m = place.y_m - receiver_m.y();
  const T below_m = receiver_m.z() - problem.setting.camera_m.z() + scale_m * path[kDrop];
  if (!(ahead_m > T(0.0))) return false;
  const T level2_m2 = ahead_m * ahead_m + across_m * across_m;
  seen.log_distance = 0.5 * log(level2_m2 + below_m * below_m);
  // As seen from the vehicle, whose axis lies along its path.
  seen.azimuth_rad = atan2(across_m, ahead_m) - place.heading_rad;
  seen.elevation_rad = atan2(below_m, sqrt(level2_m2));
  seen.log_cosine = log(ahead_m) - seen.log_distance;
  return true;
}

/// ln of the received power over the power unit, without background, and its slope by azimuth.
struct LogPower {
  double value = 0.0, by_azimuth = 0.0;
  std::array<double, kBeamWaves> waves{};  ///< what each cosine is multiplied with

  LogPower(const double* light, const LightSetting& setting, double log_scale,
           const LightPath<double>& seen);
};

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
