#include "evaluate/speed_statistics.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "core/quantity.h"

namespace vildar {
namespace {

// Linear between the order statistics, the first at 0 and the last at 1.
double quantile(const std::vector<double>& sorted, double part) {
  const double place = part * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return std::lerp(sorted[below], sorted[above], place - static_cast<double>(below));
}

std::optional<double> mean(const std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

ErrorSpread spread_of(std::vector<double> errors) {
  ErrorSpread spread;
  if (errors.empty()) return spread;
  spread.bias = mean(errors);
  for (double& error : errors) error = std::abs(error);
  std::ranges::sort(errors);
  spread.mean_abs = mean(errors);
  spread.median_abs = quantile(errors, 0.5);
  spread.p95_abs = quantile(errors, 0.95);
  spread.max = errors.back();
  return spread;
}

}  // namespace

std::optional<double> SpeedPair::error_percent() const {
  constexpr double kStands_mps = 0.1;
  if (true_mps < kStands_mps) return std::nullopt;
  return 100.0 * error_mps() / true_mps;
}

std::optional<double> SpeedPair::z() const {
  if (!stated.std_mps) return std::nullopt;
  return error_mps() / *stated.std_mps;
}

std::optional<bool> SpeedPair::inside_95() const {
  if (!stated.lo95_mps || !stated.hi95_mps) return std::nullopt;
  return *stated.lo95_mps <= true_mps && true_mps <= *stated.hi95_mps;
}

bool SpeedPair::within_limits() const {
  const double true_kmh = kmh_from_mps(true_mps);
  const double limit_kmh = true_kmh <= 100.0 ? 3.0 : 0.03 * true_kmh;
  return std::abs(kmh_from_mps(error_mps())) <= limit_kmh;
}

SpeedStatistics speed_statistics(std::span<const SpeedPair> pairs) {
  std::vector<double> kmh, percent, within, inside, z_squared;
  for (const SpeedPair& pair : pairs) {
    kmh.push_back(kmh_from_mps(pair.error_mps()));
    if (const auto value = pair.error_percent()) percent.push_back(*value);
    within.push_back(pair.within_limits() ? 1.0 : 0.0);
    if (const auto value = pair.inside_95()) inside.push_back(*value ? 1.0 : 0.0);
    if (const auto value = pair.z()) z_squared.push_back(*value * *value);
  }
  SpeedStatistics statistics;
  statistics.count = pairs.size();
  statistics.kmh = spread_of(kmh);
  statistics.percent = spread_of(percent);
  statistics.share_within_limits = mean(within);
  statistics.coverage = mean(inside);
  if (const auto value = mean(z_squared)) statistics.z_rms = std::sqrt(*value);
  return statistics;
}

}  // namespace vildar
