#include "estimate/joint_cost.h"

#include <ceres/jet.h>

namespace vildar {
namespace {

// The time shift and the photodiode's place move what is seen beside the path.
constexpr int kTime = kPathParameters, kMoved = kTime + 1, kMoving = kMoved + 1;
using Jet = ceres::Jet<double, kMoving>;

bool path_of(const double* path, const GeometryProblem& problem, const Receiver& receiver,
             double moved_m, double tau_s, bool slopes, LightPath<Jet>& seen) {
  if (!slopes) {
    LightPath<double> plain;
    if (!light_path(path, problem, receiver.position_m, moved_m, tau_s, plain)) return false;
    seen = {Jet(plain.log_distance), Jet(plain.azimuth_rad), Jet(plain.elevation_rad),
            Jet(plain.log_cosine)};
    return true;
  }
  std::array<Jet, kPathParameters> jets;
  for (int i = 0; i < kPathParameters; ++i) jets[static_cast<std::size_t>(i)] = Jet(path[i], i);
  return light_path(jets.data(), problem, receiver.position_m, Jet(moved_m, kMoved),
                    Jet(tau_s, kTime), seen);
}

}  // namespace

LogPower::LogPower(const double* light, const LightSetting& setting, double log_scale,
                   const LightPath<double>& seen) {
  const double azimuth_rad = seen.azimuth_rad;
  value = light[kLogGain] + light[kExponent] * (log_scale - seen.log_distance) -
          light[kBeamWidth] * azimuth_rad * azimuth_rad - light[kBeamTilt] * seen.elevation_rad +
          setting.cosine_exponent * seen.log_cosine;
  by_azimuth = -2.0 * light[kBeamWidth] * azimuth_rad;
  constexpr double kPerTurn = kPi / kBeamEdge_rad;
  const double cosine = std::cos(kPerTurn * azimuth_rad), sine = std::sin(kPerTurn * azimuth_rad);
  double c = 1.0, s = 0.0;  // of k times the angle
  for (int k = 1; k <= kBeamWaves; ++k) {
    const double next = c * cosine - s * sine;
    s = s * cosine + c * sine;
    c = next;
    waves[static_cast<std::size_t>(k - 1)] = c - 1.0;
    value += light[kBeamWave + k - 1] * (c - 1.0);
    by_azimuth -= light[kBeamWave + k - 1] * k * kPerTurn * s;
  }
}

bool BlockResidual::Evaluate(double const* const* unknowns, double* residual,
                             double** jacobians) const {
  const double* path = unknowns[0];
  const double* light = unknowns[1];
  const double* own = unknowns[2];
  const double tau_s = block_.time_s - setting_.problem->reference_s + light[kTimeShift];
  LightPath<Jet> seen;
  if (!path_of(path, *setting_.problem, receiver_, own[kAhead], tau_s, jacobians != nullptr, seen))
    return false;
  const LogPower power(
      light, setting_, path[kLogScale],
      {seen.log_distance.a, seen.azimuth_rad.a, seen.elevation_rad.a, seen.log_cosine.a});
  const double since_s = block_.time_s - receiver_.middle_s;
  const double signal = block_.bulge * std::exp(power.value + own[kLogRatio]);
  residual[0] = (block_.power - (signal + own[kBackground] + since_s * own[kDrift])) / block_.sigma;
  if (jacobians == nullptr) return true;

  const double by_log = -signal / block_.sigma;
  Eigen::Matrix<double, kMoving, 1> moving =
      power.by_azimuth * seen.azimuth_rad.v - light[kExponent] * seen.log_distance.v -
      light[kBeamTilt] * seen.elevation_rad.v + setting_.cosine_exponent * seen.log_cosine.v;
  moving[kLogScale] += light[kExponent];
  if (double* by_path = jacobians[0])
    Eigen::Map<PathVector>{by_path} = by_log * moving.head<kPathParameters>();
  if (double* by_light = jacobians[1]) {
    by_light[kLogGain] = by_log;
    by_light[kExponent] = by_log * (path[kLogScale] - seen.log_distance.a);
    by_light[kTimeShift] = by_log * moving[kTime];
    by_light[kBeamWidth] = -by_log * seen.azimuth_rad.a * seen.azimuth_rad.a;
    by_light[kBeamTilt] = -by_log * seen.elevation_rad.a;
    for (int k = 0; k < kBeamWaves; ++k)
      by_light[kBeamWave + k] = by_log * power.waves[static_cast<std::size_t>(k)];
  }
  if (double* by_own = jacobians[2]) {
    by_own[kBackground] = -1.0 / block_.sigma;
    by_own[kDrift] = -since_s / block_.sigma;
    by_own[kLogRatio] = by_log;
    by_own[kAhead] = by_log * moving[kMoved];
  }
  return true;
}

}  // namespace vildar
