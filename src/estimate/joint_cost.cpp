#include "estimate/joint_cost.h"

#include <algorithm>
#include <cmath>

#include <ceres/jet.h>

namespace vildar {
namespace {

/// ln of the power of one lamp and its slopes by where the lamp lies from the photodiode, by the
/// direction in which it points, and by the light's coefficients.
struct LampPower {
  double value = 0.0, by_ahead = 0.0, by_across = 0.0, by_below = 0.0, by_heading = 0.0;
  std::array<double, kLightParameters> by_light{};
};

LampPower lamp_power(const LightSetting& setting, const double* light, double log_scale,
                     double ahead_m, double across_m, double below_m, double heading_rad) {
  const double level2_m2 = ahead_m * ahead_m + across_m * across_m;
  const double distance2_m2 = level2_m2 + below_m * below_m;
  const double level_m = std::sqrt(level2_m2);
  const double log_distance = 0.5 * std::log(distance2_m2);
  // As seen from the vehicle, whose axis lies along its path.
  const double azimuth_rad = std::atan2(across_m, ahead_m) - heading_rad;
  const double elevation_rad = std::atan2(below_m, level_m);
  const double cosine = setting.cosine_exponent;

  LampPower power;
  power.value = light[kLogGain] + light[kExponent] * (log_scale - log_distance) -
                light[kBeamWidth] * azimuth_rad * azimuth_rad - light[kBeamTilt] * elevation_rad +
                cosine * (std::log(ahead_m) - log_distance);
  power.by_light[kLogGain] = 1.0;
  power.by_light[kExponent] = log_scale - log_distance;
  power.by_light[kBeamWidth] = -azimuth_rad * azimuth_rad;
  power.by_light[kBeamTilt] = -elevation_rad;
  double by_azimuth = -2.0 * light[kBeamWidth] * azimuth_rad;
  constexpr double kPerTurn = kPi / kBeamEdge_rad;
  const double step_cos = std::cos(kPerTurn * azimuth_rad);
  const double step_sin = std::sin(kPerTurn * azimuth_rad);
  double wave_cos = 1.0, wave_sin = 0.0;  // of k times the angle
  for (int k = 1; k <= kBeamWaves; ++k) {
    const double next_cos = wave_cos * step_cos - wave_sin * step_sin;
    wave_sin = wave_sin * step_cos + wave_cos * step_sin;
    wave_cos = next_cos;
    const double amplitude = light[kBeamWave + k - 1];
    power.value += amplitude * (wave_cos - 1.0);
    power.by_light[static_cast<std::size_t>(kBeamWave + k - 1)] = wave_cos - 1.0;
    by_azimuth -= amplitude * k * kPerTurn * wave_sin;
  }

  const double by_distance = -(light[kExponent] + cosine) / distance2_m2;  // over the distance
  const double by_level = light[kBeamTilt] * below_m / (level_m * distance2_m2);  // over the level
  power.by_ahead =
      (by_distance + by_level) * ahead_m - by_azimuth * across_m / level2_m2 + cosine / ahead_m;
  power.by_across = (by_distance + by_level) * across_m + by_azimuth * ahead_m / level2_m2;
  power.by_below = by_distance * below_m - light[kBeamTilt] * level_m / distance2_m2;
  power.by_heading = -by_azimuth;
  return power;
}

// By the parameters that say where the vehicle is, and by time.
constexpr int kOfPlace = kYaw;
using Jet = ceres::Jet<double, kOfPlace + 1>;
PathPoint<Jet> place_with_slopes(const double* path, const PathSetting& setting, double tau_s) {
  std::array<Jet, kPathParameters> jets;
  for (int i = 0; i < kOfPlace; ++i) jets[static_cast<std::size_t>(i)] = Jet(path[i], i);
  return vehicle_point(jets.data(), setting, Jet(tau_s, kOfPlace));
}

PathPoint<double> plain(const PathPoint<Jet>& place) {
  return {place.x_m.a, place.y_m.a, place.heading_rad.a};
}

}  // namespace

bool log_power(const double* path, const double* light, const LightSetting& setting,
               const Eigen::Vector3d& receiver_m, double moved_m, double tau_s, double& value,
               PowerGradient* gradient) {
  const GeometryProblem& problem = *setting.problem;
  PathPoint<Jet> slopes;
  if (gradient != nullptr) slopes = place_with_slopes(path, problem.setting, tau_s);
  const PathPoint<double> place =
      gradient != nullptr ? plain(slopes) : vehicle_point(path, problem.setting, tau_s);
  const double scale_m = std::exp(path[kLogScale]);
  const Eigen::Vector3d& camera_m = problem.setting.camera_m;
  const Eigen::Vector3d off_camera_m =
      std::exp(path[kLogScale] - setting.log_scale) * (receiver_m - camera_m);
  const double below_m = off_camera_m.z() + scale_m * path[kDrop];
  const double half_m = problem.pairs ? 0.5 * scale_m * std::exp(path[kLogSeparation]) : 0.0;
  const double heading_cos = std::cos(place.heading_rad), heading_sin = std::sin(place.heading_rad);
  std::array<LampPower, 2> lamps;
  std::array<double, 2> asides_m{half_m, -half_m};
  const std::size_t count = problem.pairs ? 2 : 1;
  for (std::size_t i = 0; i < count; ++i) {
    const double ahead_m =
        place.x_m - asides_m[i] * heading_sin - camera_m.x() - off_camera_m.x() - moved_m;
    const double across_m = place.y_m + asides_m[i] * heading_cos - camera_m.y() - off_camera_m.y();
    if (!(ahead_m > 0.0)) return false;
    lamps[i] =
        lamp_power(setting, light, path[kLogScale], ahead_m, across_m, below_m, place.heading_rad);
  }
  const double brighter = std::max(lamps[0].value, lamps[count - 1].value);
  double sum = 0.0;
  for (std::size_t i = 0; i < count; ++i) sum += std::exp(lamps[i].value - brighter);
  value = brighter + std::log(sum / static_cast<double>(count));
  if (gradient == nullptr) return true;

  LampPower both;
  double by_aside = 0.0;  // over the distance from the middle
  for (std::size_t i = 0; i < count; ++i) {
    const LampPower& lamp = lamps[i];
    const double share = std::exp(lamp.value - brighter) / sum;
    both.by_ahead += share * lamp.by_ahead;
    both.by_across += share * lamp.by_across;
    both.by_below += share * lamp.by_below;
    both.by_heading += share * (lamp.by_heading - asides_m[i] * (lamp.by_ahead * heading_cos +
                                                                 lamp.by_across * heading_sin));
    by_aside += share * asides_m[i] * (lamp.by_across * heading_cos - lamp.by_ahead * heading_sin);
    for (std::size_t k = 0; k < kLightParameters; ++k)
      gradient->light[k] = (i > 0 ? gradient->light[k] : 0.0) + share * lamp.by_light[k];
  }
  const Eigen::Matrix<double, kOfPlace + 1, 1> by_place = both.by_ahead * slopes.x_m.v +
                                                          both.by_across * slopes.y_m.v +
                                                          both.by_heading * slopes.heading_rad.v;
  gradient->path.setZero();
  gradient->path.head<kOfPlace>() = by_place.head<kOfPlace>();
  gradient->path[kLogScale] += light[kExponent] + both.by_below * below_m + by_aside -
                               both.by_ahead * off_camera_m.x() - both.by_across * off_camera_m.y();
  gradient->path[kDrop] += both.by_below * scale_m;
  gradient->path[kLogSeparation] += by_aside;
  gradient->light[kTimeShift] = by_place[kOfPlace];
  gradient->moved = -both.by_ahead;
  return true;
}

bool BlockResidual::Evaluate(double const* const* unknowns, double* residual,
                             double** jacobians) const {
  const double *path = unknowns[0], *light = unknowns[1], *own = unknowns[2];
  const double tau_s = block_.time_s - setting_.problem->reference_s + light[kTimeShift];
  double value = 0.0;
  PowerGradient gradient;
  if (!log_power(path, light, setting_, receiver_.position_m, own[kAhead], tau_s, value,
                 jacobians == nullptr ? nullptr : &gradient))
    return false;
  const double power = block_.bulge * std::exp(value + own[kLogRatio]);
  const double later_s = block_.time_s - receiver_.middle_s;
  residual[0] = (block_.power - power - own[kBackground] - later_s * own[kDrift]) / block_.sigma;
  if (jacobians == nullptr) return true;
  const double by_value = -power / block_.sigma;
  if (double* by_path = jacobians[0]) Eigen::Map<PathVector>{by_path} = by_value * gradient.path;
  if (double* by_light = jacobians[1])
    for (std::size_t i = 0; i < kLightParameters; ++i) by_light[i] = by_value * gradient.light[i];
  if (double* by_own = jacobians[2]) {
    by_own[kBackground] = -1.0 / block_.sigma;
    by_own[kDrift] = -later_s / block_.sigma;
    by_own[kLogRatio] = by_value;
    by_own[kAhead] = by_value * gradient.moved;
  }
  return true;
}

}  // namespace vildar
