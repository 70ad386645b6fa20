#pragma once

#include <cmath>
#include <vector>

#include "core/random.h"
#include "estimate/power_problem.h"

namespace vildar::power_pass {

// The paper's pass: V = 20 m/s, d = 0.5 m, gamma = 1.21, sampled at 1 kHz; half-power angle 40
// degrees. K = 1 W: with a noise relative to the power at the start it cancels.
inline constexpr double kSpeed_mps = 20.0;
inline constexpr double kPerpendicular_m = 0.5;
inline constexpr double kExponent = 1.21;
inline constexpr double kCosine = 3.60078;

struct Window {
  const char* name;
  double from_m, to_m;
  /// Paper's LS over the bound without the cosine, at 40 dB and above.
  double paper_ratio;
};
inline constexpr Window kWindows[] = {{"15 to 9 m", 15.0, 9.0, 1.13},
                                      {"10.5 to 4.5 m", 10.5, 4.5, 1.37},
                                      {"6.5 to 0.5 m", 6.5, 0.5, 3.35},
                                      {"15 to 0.6 m", 15.0, 0.6, 5.5}};

struct Samples {
  std::vector<double> time_s, power_w;
};

inline double straight_power_w(double range_m, double cosine) {
  const double distance_m = std::hypot(range_m, kPerpendicular_m);
  return std::pow(distance_m, -kExponent) * std::pow(range_m / distance_m, cosine);
}

/// Noise-free samples every millisecond, the first at `from_m`.
inline Samples straight_window(const Window& window, double cosine) {
  Samples samples;
  const auto count =
      static_cast<int>(std::lround((window.from_m - window.to_m) / kSpeed_mps * 1000.0));
  for (int i = 0; i < count; ++i) {
    samples.time_s.push_back(i * 1e-3);
    samples.power_w.push_back(straight_power_w(window.from_m - kSpeed_mps * i * 1e-3, cosine));
  }
  return samples;
}

inline std::vector<double> with_noise(const std::vector<double>& power_w, double sigma_w,
                                      Random& random) {
  std::vector<double> noisy = power_w;
  for (double& power : noisy) power += sigma_w * random.normal();
  return noisy;
}

/// Noise of an electrical SNR at R = 15 m, without the cosine.
inline double sigma_w(double snr_db) {
  return straight_power_w(15.0, 0.0) * std::pow(10.0, -snr_db / 20.0);
}

/// K, d and gamma known exactly, V and R not at all.
inline PowerProblem straight_problem(const Samples& samples, double cosine, const double& sigma_w) {
  PowerProblem problem;
  problem.time_s = samples.time_s;
  problem.power_w = samples.power_w;
  problem.sigma_w = std::span(&sigma_w, 1);
  problem.setting.cosine_exponent = cosine;
  problem.known[kPowerLogGain] = Uncertain{0.0, 0.0};
  problem.known[kPowerPerpendicular] = Uncertain{kPerpendicular_m, 0.0};
  problem.known[kPowerExponent] = Uncertain{kExponent, 0.0};
  return problem;
}

inline PowerVector straight_truth(double from_m) {
  PowerVector truth = PowerVector::Zero();
  truth[kPowerSpeed] = kSpeed_mps;
  truth[kPowerRange] = from_m;
  truth[kPowerPerpendicular] = kPerpendicular_m;
  truth[kPowerExponent] = kExponent;
  truth[kPowerRadius] = 40.0;
  return truth;
}

}  // namespace vildar::power_pass
