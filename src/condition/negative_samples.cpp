#include "condition/negative_samples.h"

#include <algorithm>
#include <vector>

#include <Eigen/Core>

namespace vildar {
namespace {

constexpr double kNoiseSigmas = 10.0;
constexpr double kSpreads = 4.0;

double quantile_w(std::vector<float>& powers_w, double fraction) {
  const auto rank =
      static_cast<std::ptrdiff_t>(fraction * static_cast<double>(powers_w.size() - 1));
  std::nth_element(powers_w.begin(), powers_w.begin() + rank, powers_w.end());
  return powers_w[static_cast<std::size_t>(rank)];
}

}  // namespace

std::int64_t drop_negative(PowerTrace& trace) {
  if (trace.power_w.empty()) return 0;
  const double noise_w = kNoiseSigmas * trace.noise_sigma_w;
  const float least_w = Eigen::Map<const Eigen::ArrayXf>(
                            trace.power_w.data(), static_cast<Eigen::Index>(trace.power_w.size()))
                            .minCoeff();
  if (!(least_w < 0.0F && least_w < -noise_w)) return 0;

  // A flickering lamp's dark half lies within this spread: of a sine between its quantiles at 0.1
  // and 0.3 there is a fifth of its swing.
  std::vector<float> sorted_w = trace.power_w;
  const double dark_w = quantile_w(sorted_w, 0.1);
  const double spread_w = quantile_w(sorted_w, 0.3) - dark_w;
  const double limit_w = std::min(0.0, dark_w - kSpreads * spread_w) - noise_w;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < trace.power_w.size(); ++i) {
    if (trace.power_w[i] < limit_w) continue;
    trace.time_s[kept] = trace.time_s[i];
    trace.power_w[kept] = trace.power_w[i];
    ++kept;
  }
  const std::size_t dropped = trace.power_w.size() - kept;
  trace.time_s.resize(kept);
  trace.power_w.resize(kept);
  return static_cast<std::int64_t>(dropped);
}

}  // namespace vildar
