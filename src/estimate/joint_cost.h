#pragma once

#include <array>
#include <cmath>

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

/// ln of the received power over the power unit, without background; false where the vehicle is not
/// ahead of the photodiode.
template <class T>
bool log_power(const T* path, const T* light, const LightSetting& setting,
               const Eigen::Vector3d& receiver_m, const T& moved_m, const T& tau_s, T& value) {
  using std::atan2;
  using std::cos;
  using std::exp;
  using std::log;
  using std::sqrt;
  const GeometryProblem& problem = *setting.problem;
  const T scale_m = exp(path[kLogScale]);
  const PathPoint<T> place = vehicle_point(path, problem.setting, tau_s);
  const T ahead_m = place.x_m - receiver_m.x() - moved_m;
  const T across_m = place.y_m - receiver_m.y();
  const T below_m = receiver_m.z() - problem.setting.camera_m.z() + scale_m * path[kDrop];
  if (!(ahead_m > T(0.0))) return false;
  const T level2_m2 = ahead_m * ahead_m + across_m * across_m;
  const T distance_m = sqrt(level2_m2 + below_m * below_m);
  // As seen from the vehicle, whose axis lies along its path.
  const T azimuth_rad = atan2(across_m, ahead_m) - place.heading_rad;
  const T elevation_rad = atan2(below_m, sqrt(level2_m2));
  value = light[kLogGain] + light[kExponent] * (path[kLogScale] - log(distance_m)) -
          light[kBeamWidth] * azimuth_rad * azimuth_rad - light[kBeamTilt] * elevation_rad;
  if (setting.cosine_exponent > 0.0) value += setting.cosine_exponent * log(ahead_m / distance_m);
  for (int k = 1; k <= kBeamWaves; ++k)
    value += light[kBeamWave + k - 1] * (cos(k * kPi / kBeamEdge_rad * azimuth_rad) - 1.0);
  return true;
}

/// A block's mean in power units, and what the model needs to know of it.
struct LitBlock {
  double time_s = 0.0;
  double power = 0.0;
  double noise = 0.0;  ///< sigma of white noise
  double light = 0.0;  ///< without background, not below zero
  double bulge = 1.0;  ///< mean of the light over the block, over that at its middle
  double sigma = 0.0;  ///< as used: noise, what the model leaves out, and correlation
};

/// Whitened error of one block's mean.
struct BlockResidual {
  const LightSetting* setting;
  const Receiver* receiver;
  const LitBlock* block;

  template <class T>
  bool operator()(const T* path, const T* light, const T* own, T* residual) const {
    using std::exp;
    const T tau_s = block->time_s - setting->problem->reference_s + light[kTimeShift];
    T value;
    if (!log_power(path, light, *setting, receiver->position_m, own[kAhead], tau_s, value))
      return false;
    const T expected = block->bulge * exp(value + own[kLogRatio]) + own[kBackground] +
                       (block->time_s - receiver->middle_s) * own[kDrift];
    residual[0] = (block->power - expected) / block->sigma;
    return true;
  }
};

}  // namespace vildar
