#include "estimate/joint_cost.h"

#include <algorithm>
#include <cmath>

#include <ceres/jet.h>

namespace vildar {
namespace {

/// How a photodiode sees a lamp, and the vehicle's own axis from there.
template <class T>
struct LampRay {
  T log_distance;  ///< over X
  T log_cosine;    ///< of incidence
  T azimuth_rad, elevation_rad;
};

template <class T>
struct LampRays {
  std::array<LampRay<T>, 2> lamps;
  std::size_t count = 1;
};

template <class T>
bool see_lamps(const T* path, const GeometryProblem& problem, const Eigen::Vector3d& receiver_m,
               const T& moved_m, const T& tau_s, LampRays<T>& rays) {
  using std::atan2;
  using std::cos;
  using std::exp;
  using std::log;
  using std::sin;
  using std::sqrt;
  const PathPoint<T> place = vehicle_point(path, problem.setting, tau_s);
  const T scale_m = exp(path[kLogScale]);
  const T below_m = receiver_m.z() - problem.setting.camera_m.z() + scale_m * path[kDrop];
  T aside_m(0.0);
  if (problem.pairs) {
    rays.count = 2;
    aside_m = 0.5 * scale_m * exp(path[kLogSeparation]);
  }
  for (std::size_t i = 0; i < rays.count; ++i) {
    T ahead_m = place.x_m - receiver_m.x() - moved_m;
    T across_m = place.y_m - receiver_m.y();
    if (problem.setting.bend != 0.0) {
      ahead_m -= aside_m * sin(place.heading_rad);
      across_m += aside_m * cos(place.heading_rad);
    } else {
      across_m += aside_m;
    }
    aside_m = -aside_m;
    if (!(ahead_m > T(0.0))) return false;
    const T level2_m2 = ahead_m * ahead_m + across_m * across_m;
    const T log_distance_m = 0.5 * log(level2_m2 + below_m * below_m);
    rays.lamps[i] = {log_distance_m - path[kLogScale], log(ahead_m) - log_distance_m,
                     atan2(across_m, ahead_m) - place.heading_rad, atan2(below_m, sqrt(level2_m2))};
  }
  return true;
}

/// ln of the power of one lamp, and how it follows the light's coefficients and the azimuth.
double lamp_power(const LightSetting& setting, const double* light, double log_distance,
                  double log_cosine, double azimuth_rad, double elevation_rad,
                  std::array<double, kLightParameters>& by_light, double& by_azimuth) {
  double value = light[kLogGain] - light[kExponent] * log_distance -
                 light[kBeamWidth] * azimuth_rad * azimuth_rad - light[kBeamTilt] * elevation_rad +
                 setting.cosine_exponent * log_cosine;
  by_light[kLogGain] = 1.0;
  by_light[kExponent] = -log_distance;
  by_light[kBeamWidth] = -azimuth_rad * azimuth_rad;
  by_light[kBeamTilt] = -elevation_rad;
  by_azimuth = -2.0 * light[kBeamWidth] * azimuth_rad;
  constexpr double kStep = kPi / kBeamEdge_rad;
  const double first_cos = std::cos(kStep * azimuth_rad), first_sin = std::sin(kStep * azimuth_rad);
  double wave_cos = 1.0, wave_sin = 0.0;
  for (int k = 1; k <= kBeamWaves; ++k) {
    const double next_cos = wave_cos * first_cos - wave_sin * first_sin;
    wave_sin = wave_sin * first_cos + wave_cos * first_sin;
    wave_cos = next_cos;
    const double amplitude = light[kBeamWave + k - 1];
    value += amplitude * (wave_cos - 1.0);
    by_light[static_cast<std::size_t>(kBeamWave + k - 1)] = wave_cos - 1.0;
    by_azimuth -= amplitude * k * kStep * wave_sin;
  }
  return value;
}

using Jet = ceres::Jet<double, kPathParameters + 2>;
double number(double value) { return value; }
double number(const Jet& value) { return value.a; }

struct LampPowers {
  std::array<double, 2> values{}, by_azimuth{};
  std::array<std::array<double, kLightParameters>, 2> by_light{};
};

template <class T>
double power_of(const LampRays<T>& rays, const LightSetting& setting, const double* light,
                LampPowers& sum) {
  for (std::size_t i = 0; i < rays.count; ++i) {
    const LampRay<T>& ray = rays.lamps[i];
    sum.values[i] = lamp_power(setting, light, number(ray.log_distance), number(ray.log_cosine),
                               number(ray.azimuth_rad), number(ray.elevation_rad), sum.by_light[i],
                               sum.by_azimuth[i]);
  }
  if (rays.count == 1) return sum.values[0];
  const double brighter = std::max(sum.values[0], sum.values[1]);
  return brighter +
         std::log(0.5 * (std::exp(sum.values[0] - brighter) + std::exp(sum.values[1] - brighter)));
}

}  // namespace

bool log_power(const double* path, const double* light, const LightSetting& setting,
               const Eigen::Vector3d& receiver_m, double moved_m, double tau_s, double& value,
               PowerGradient* gradient) {
  const GeometryProblem& problem = *setting.problem;
  if (gradient == nullptr) {
    LampRays<double> rays;
    LampPowers sum;
    if (!see_lamps(path, problem, receiver_m, moved_m, tau_s, rays)) return false;
    value = power_of(rays, setting, light, sum);
    return true;
  }
  std::array<Jet, kPathParameters> jets;
  for (int i = 0; i < kPathParameters; ++i) jets[static_cast<std::size_t>(i)] = Jet(path[i], i);
  LampRays<Jet> rays;
  LampPowers sum;
  if (!see_lamps(jets.data(), problem, receiver_m, Jet(moved_m, kPathParameters + 1),
                 Jet(tau_s, kPathParameters), rays))
    return false;
  value = power_of(rays, setting, light, sum);
  gradient->geometry.setZero();
  gradient->light.fill(0.0);
  for (std::size_t i = 0; i < rays.count; ++i) {
    const double share = std::exp(sum.values[i] - value) / static_cast<double>(rays.count);
    const LampRay<Jet>& ray = rays.lamps[i];
    gradient->geometry +=
        share *
        (sum.by_azimuth[i] * ray.azimuth_rad.v - light[kExponent] * ray.log_distance.v -
         light[kBeamTilt] * ray.elevation_rad.v + setting.cosine_exponent * ray.log_cosine.v);
    for (std::size_t k = 0; k < kLightParameters; ++k)
      gradient->light[k] += share * sum.by_light[i][k];
  }
  gradient->light[kTimeShift] = gradient->geometry[kPathParameters];
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
  if (jacobians[0] != nullptr)
    for (int i = 0; i < kPathParameters; ++i) jacobians[0][i] = by_value * gradient.geometry[i];
  if (jacobians[1] != nullptr)
    for (std::size_t i = 0; i < kLightParameters; ++i)
      jacobians[1][i] = by_value * gradient.light[i];
  if (jacobians[2] != nullptr) {
    jacobians[2][kBackground] = -1.0 / block_.sigma;
    jacobians[2][kDrift] = -later_s / block_.sigma;
    jacobians[2][kLogRatio] = by_value;
    jacobians[2][kAhead] = by_value * gradient.geometry[kPathParameters + 1];
  }
  return true;
}

}  // namespace vildar
