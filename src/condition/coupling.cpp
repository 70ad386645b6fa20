#include "condition/coupling.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "condition/condition.h"
#include "condition/noise.h"

namespace vildar {
namespace {

constexpr double kBlock_s = 0.02;

struct Level {
  double time_s, power_w;
};

/// Brightest within 2 s, and bright beside what is usual.
std::vector<std::size_t> vehicles_in(const std::vector<Level>& levels) {
  constexpr double kAlone_s = 2.0, kLeastShare = 0.2;
  std::vector<double> sorted_w;
  for (const Level& level : levels) sorted_w.push_back(level.power_w);
  const double usual_w = median_of(sorted_w);
  const double most_w = *std::ranges::max_element(sorted_w);
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    if (levels[i].power_w < usual_w + kLeastShare * (most_w - usual_w)) continue;
    if (!found.empty() && levels[i].time_s - levels[found.back()].time_s < kAlone_s) {
      if (levels[i].power_w > levels[found.back()].power_w) found.back() = i;
    } else {
      found.push_back(i);
    }
  }
  return found;
}

std::size_t darkest_of(const std::vector<Level>& levels, double from_s, double to_s) {
  const auto first = std::ranges::lower_bound(levels, from_s, {}, &Level::time_s);
  const auto end = std::ranges::upper_bound(levels, to_s, {}, &Level::time_s);
  return static_cast<std::size_t>(
      std::min_element(first, end,
                       [](const Level& a, const Level& b) { return a.power_w < b.power_w; }) -
      levels.begin());
}

/// Whether the level swings below what it was before and creeps back.
bool swings_back(const std::vector<Level>& levels, std::size_t peak, double next_s,
                 double sigma_w) {
  constexpr double kBefore_s = 6.0, kRises_s = 1.0, kFalls_s = 2.0, kLongest_s = 10.0;
  constexpr double kLeastShare = 0.02, kLeastSigmas = 20.0, kHalf = 0.5, kEvenly = 0.22;
  constexpr std::size_t kAtOnce = 10;  // blocks: as sound cards do
  const double peak_s = levels[peak].time_s;
  const std::size_t before = darkest_of(levels, peak_s - kBefore_s, peak_s - kRises_s);
  const std::size_t after = darkest_of(levels, peak_s, std::min(peak_s + kFalls_s, next_s));
  if (before >= peak || after >= levels.size()) return false;
  const double swing_w = levels[before].power_w - levels[after].power_w;
  if (swing_w < kLeastShare * (levels[peak].power_w - levels[after].power_w) ||
      swing_w < kLeastSigmas * sigma_w)
    return false;
  const double until_s = std::min(levels[after].time_s + kLongest_s, next_s - kRises_s);
  for (std::size_t i = after; i < levels.size() && levels[i].time_s < until_s; ++i) {
    if (levels[i].power_w - levels[after].power_w < kHalf * swing_w) continue;
    return i - after < kAtOnce ||
           levels[after + (i - after) / 2].power_w - levels[after].power_w > kEvenly * swing_w;
  }
  return false;
}

}  // namespace

bool blocks_constant_light(const PowerTrace& trace) {
  constexpr double kMost = 0.6;
  if (trace.time_s.size() < 2) return false;
  const double block_s = std::max(kBlock_s, 4.0 * trace.sample_period_s);
  std::vector<Level> levels;
  double samples = 1.0;
  for (const PowerBlock& block :
       block_means(trace, trace.time_s.front(), trace.time_s.back(), block_s)) {
    levels.push_back({block.time_s, block.power_w});
    samples = std::max(samples, static_cast<double>(block.samples));
  }
  if (levels.empty()) return false;
  const double sigma_w = trace.noise_sigma_w / std::sqrt(samples);
  const std::vector<std::size_t> vehicles = vehicles_in(levels);
  std::size_t told = 0, swing = 0;
  for (std::size_t k = 0; k < vehicles.size(); ++k) {
    const double next_s = k + 1 < vehicles.size() ? levels[vehicles[k + 1]].time_s : INFINITY;
    if (levels[vehicles[k]].time_s - levels.front().time_s < 1.5 ||
        std::min(next_s, levels.back().time_s) - levels[vehicles[k]].time_s < 1.5)
      continue;
    ++told;
    swing += swings_back(levels, vehicles[k], next_s, sigma_w);
  }
  return told > 0 && static_cast<double>(swing) > kMost * static_cast<double>(told);
}

}  // namespace vildar
