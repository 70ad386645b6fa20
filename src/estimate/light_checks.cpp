#include "estimate/light_checks.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "estimate/speed_gate.h"

namespace vildar {

bool pulses(const PowerTrace& trace, double from_s, double peak_s) {
  constexpr double kLeastShare = 0.05, kTimesNoise = 2.0, kBeforePeak_s = 0.02;
  constexpr double kBrightest = 0.25;  // of the time up to the peak
  constexpr std::size_t kEdges = 6;    // bends of a lamp that passes another photodiode
  constexpr std::size_t kFewest = 4 * kEdges;
  const auto sample_at = [&](double time_s) {
    return static_cast<std::size_t>(
        std::lower_bound(trace.time_s.begin(), trace.time_s.end(), time_s) - trace.time_s.begin());
  };
  const std::size_t first = sample_at(peak_s - kBrightest * (peak_s - from_s));
  const std::size_t last = sample_at(peak_s - kBeforePeak_s);
  if (last < first + kFewest) return false;
  double sum_w = 0.0;
  std::vector<double> bends_w2;
  const auto light_w = [&](std::size_t i) { return trace.power_w[i] - trace.ambient_w; };
  for (std::size_t i = first + 2; i < last; ++i) {
    const double bend_w = light_w(i) - 2.0 * light_w(i - 1) + light_w(i - 2);
    bends_w2.push_back(bend_w * bend_w / 6.0);  // of white noise: its variance
    sum_w += light_w(i);
  }
  std::sort(bends_w2.begin(), bends_w2.end());
  const double mean_w = sum_w / static_cast<double>(bends_w2.size());
  bends_w2.resize(bends_w2.size() - kEdges);
  double square_w2 = 0.0;
  for (const double bend_w2 : bends_w2) square_w2 += bend_w2 / static_cast<double>(bends_w2.size());
  return std::sqrt(square_w2) > std::max(kLeastShare * mean_w, kTimesNoise * trace.noise_sigma_w);
}

double others_std_mps(double share, double speed_mps) {
  constexpr double kOtherSpeeds = 0.15, kOfRise = 2.0;
  return kOtherSpeeds * kOfRise * share * speed_mps;
}

bool of_several(const DelayFit& fit, std::size_t lanes, double others_share) {
  constexpr double kWorstFactor = 5.0, kClearChi2 = 30.0, kMostOthers = 0.2;
  const double explained_mps = others_std_mps(others_share, fit.speed.speed_mps);
  return fit.sigma_factor > kWorstFactor ||
         !(std::abs(fit.acceleration_mps2) < kHardestBraking_mps2) ||
         fit.surely_brakes_mps2 > kHardestBraking_mps2 ||
         fit.surely_speeds_up_mps2 > kHardestSpeedingUp_mps2 ||
         (lanes > 1 && fit.wander_chi2 > kClearChi2 &&
          (fit.bend_mps > explained_mps || others_share > kMostOthers));
}

}  // namespace vildar
