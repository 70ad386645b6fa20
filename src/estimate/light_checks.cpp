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

bool stands(const PowerTrace& trace, double from_s, double peak_s) {
  constexpr double kMean_s = 0.05, kStands_s = 1.2, kChange_ln = 0.02, kNoise_ln = 0.004;
  constexpr double kRises_ln = 0.3, kMostGap_s = 0.3;
  struct Mean {
    double time_s, light_ln;
  };
  std::vector<Mean> means;
  const auto sample_at = [&](double time_s) {
    return static_cast<std::size_t>(std::ranges::lower_bound(trace.time_s, time_s) -
                                    trace.time_s.begin());
  };
  const std::size_t end = sample_at(peak_s);
  for (std::size_t first = sample_at(from_s), last = first; first < end; first = last) {
    double sum_w = 0.0;
    for (; last < end && trace.time_s[last] < trace.time_s[first] + kMean_s; ++last)
      sum_w += trace.power_w[last] - trace.ambient_w;
    const auto samples = static_cast<double>(last - first);
    const double sigma_w = trace.noise_sigma_w / std::sqrt(samples);
    if (sum_w / samples > sigma_w / kNoise_ln)
      means.push_back({trace.time_s[first], std::log(sum_w / samples)});
  }
  std::vector<double> least_before_ln, most_after_ln(means.size());
  for (std::size_t i = 0; i < means.size(); ++i)
    least_before_ln.push_back(i == 0 ? means[i].light_ln
                                     : std::min(least_before_ln[i - 1], means[i].light_ln));
  for (std::size_t i = means.size(); i-- > 0;)
    most_after_ln[i] = i + 1 == means.size() ? means[i].light_ln
                                             : std::max(most_after_ln[i + 1], means[i].light_ln);
  for (std::size_t first = 0; first < means.size(); ++first) {
    double least_ln = means[first].light_ln, most_ln = least_ln;
    for (std::size_t next = first + 1; next < means.size(); ++next) {
      if (means[next].time_s - means[next - 1].time_s > kMostGap_s) break;
      least_ln = std::min(least_ln, means[next].light_ln);
      most_ln = std::max(most_ln, means[next].light_ln);
      if (most_ln - least_ln > kChange_ln) break;
      if (means[next].time_s - means[first].time_s < kStands_s) continue;
      if (most_after_ln[next] - most_ln > kRises_ln &&
          least_ln - least_before_ln[first] > kRises_ln)
        return true;
      break;
    }
  }
  return false;
}

double others_std_mps(double share, double speed_mps) {
  constexpr double kOtherSpeeds = 0.15, kOfRise = 2.0;
  return kOtherSpeeds * kOfRise * share * speed_mps;
}

void widen(DelayFit& fit, double std_mps) {
  constexpr double kTwoSided95 = 1.959963984540054;
  SpeedEstimate& speed = fit.speed;
  fit.covariance(0, 0) += std_mps * std_mps;
  speed.std_mps = std::hypot(speed.std_mps, std_mps);
  const double log_std = speed.std_mps / speed.speed_mps;
  speed.lo95_mps = speed.speed_mps * std::exp(-kTwoSided95 * log_std);
  speed.hi95_mps = speed.speed_mps * std::exp(kTwoSided95 * log_std);
}

double pulsing_std_mps(const PowerTraceFacts& trace, double from_s, double to_s, double baseline_m,
                       double speed_mps) {
  constexpr double kOfSample = 0.4, kOfPeriod = 0.03;
  double most_s = 0.0;
  for (const PulsingLight& light : trace.pulsing)
    if (light.from_s < to_s && light.to_s > from_s)
      most_s = std::max(
          most_s, std::hypot(kOfSample * trace.sample_period_s, kOfPeriod / light.frequency_hz));
  return speed_mps * speed_mps * most_s / baseline_m;
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

double log_light_std(const PowerTraceFacts& trace, double from_s, double to_s) {
  double most = 0.0;
  for (const PulsingLight& light : trace.pulsing)
    if (light.from_s < to_s && light.to_s > from_s)
      most = std::max(most, light.duty_std / light.duty);
  return most;
}

bool is_mostly_clipped(const PowerTrace& trace, double from_s, double to_s) {
  if (trace.time_s.empty()) return false;
  from_s = std::max(from_s, trace.time_s.front());
  to_s = std::min(to_s, trace.time_s.back());
  double clipped_s = 0.0;
  for (const ClippedTime& one : trace.clipped)
    clipped_s += std::max(0.0, std::min(one.to_s, to_s) - std::max(one.from_s, from_s));
  return clipped_s > 0.5 * std::max(0.0, to_s - from_s);
}

}  // namespace vildar
