#include "condition/coupling.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
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

std::optional<std::size_t> darkest_of(const std::vector<Level>& levels, double from_s,
                                      double to_s) {
  const auto first = std::ranges::lower_bound(levels, from_s, {}, &Level::time_s);
  const auto end = std::ranges::upper_bound(levels, to_s, {}, &Level::time_s);
  if (first >= end) return std::nullopt;
  return std::ranges::min_element(first, end, {}, &Level::power_w) - levels.begin();
}

struct Swing {
  double share = 0.0;  ///< of the vehicle's light, by which the level is below what it was before
  bool back = false;   ///< it creeps back
};

/// Whether light stays within `most_w` of what it is at level `first` for a second: what rises at
/// once is the light of the next vehicle, or of one that was in view as the trace began, not the
/// dark.
bool holds(const std::vector<Level>& levels, std::size_t first, double most_w) {
  constexpr double kFor_s = 1.0;
  for (std::size_t i = first; i < levels.size(); ++i) {
    if (levels[i].time_s - levels[first].time_s >= kFor_s) return true;
    if (std::abs(levels[i].power_w - levels[first].power_w) > most_w) return false;
  }
  return false;
}

/// Whether the trace is steadily dark, as no amplifier that swings back is, somewhere below.
bool darker_elsewhere(const std::vector<Level>& levels, double dark_w, double swing_w) {
  constexpr double kBelow = 0.1, kSteady = 0.05;  // of the swing
  for (std::size_t i = 0; i < levels.size(); ++i)
    if (levels[i].power_w < dark_w - kBelow * swing_w && holds(levels, i, kSteady * swing_w))
      return true;
  return false;
}

/// Whether what came back goes again, as the light of another vehicle's tail lamps does that come
/// into view.
bool falls_again(const std::vector<Level>& levels, std::size_t dark, double until_s,
                 double swing_w) {
  constexpr double kFall = 0.3;  // of the swing
  double most_w = levels[dark].power_w;
  for (std::size_t i = dark; i < levels.size() && levels[i].time_s < until_s; ++i) {
    most_w = std::max(most_w, levels[i].power_w);
    if (levels[i].power_w < most_w - kFall * swing_w) return true;
  }
  return false;
}

Swing swing_after(const std::vector<Level>& levels, std::size_t peak, double next_s,
                  double sigma_w) {
  constexpr double kBefore_s = 6.0, kRises_s = 1.0, kFalls_s = 2.0, kLongest_s = 10.0;
  constexpr double kLeastSigmas = 20.0, kRise = 0.5;  // of the swing
  // Of the swing: an exponential is 0.29 of the way where half of the time to its half is over,
  // a straight rise 0.25.
  constexpr double kHalf = 0.5, kEvenly = 0.26;
  // Blocks: sound cards swing back at once, and what does within a second has hardly left its turn.
  constexpr std::size_t kAtOnce = 10, kSoon = 50;
  constexpr double kEvenlySoon = 0.15;
  const double peak_s = levels[peak].time_s;
  const auto before = darkest_of(levels, peak_s - kBefore_s, peak_s - kRises_s);
  const auto after = darkest_of(levels, peak_s, std::min(peak_s + kFalls_s, next_s));
  if (!before || !after) return {};
  const double dark_w = levels[*after].power_w;
  const double swing_w = levels[*before].power_w - dark_w;
  if (swing_w < kLeastSigmas * sigma_w || !holds(levels, *before, kRise * swing_w)) return {};
  Swing swing{swing_w / (levels[peak].power_w - dark_w)};
  const double until_s = std::min(levels[*after].time_s + kLongest_s, next_s - kRises_s);
  for (std::size_t i = *after; i < levels.size() && levels[i].time_s < until_s; ++i) {
    if (levels[i].power_w - dark_w < kHalf * swing_w) continue;
    const std::size_t blocks = i - *after;
    const double least = blocks < kSoon ? kEvenlySoon : kEvenly;
    swing.back = blocks < kAtOnce || levels[*after + blocks / 2].power_w - dark_w > least * swing_w;
    break;
  }
  swing.back = swing.back && !darker_elsewhere(levels, dark_w, swing_w) &&
               !falls_again(levels, *after, until_s, swing_w);
  return swing;
}

/// Means of 20 ms, or of four samples, each the median of the five about it: spikes and the flash
/// of a camera are none of them.
std::vector<Level> levels_in(const PowerTrace& trace, double& sigma_w) {
  constexpr std::ptrdiff_t kBeside = 2;
  const std::vector<PowerBlock> blocks =
      block_means(trace, trace.time_s.front(), trace.time_s.back(),
                  std::max(kBlock_s, 4.0 * trace.sample_period_s));
  std::vector<Level> levels;
  std::vector<double> sigmas_w, about_w;
  const auto last = std::ssize(blocks) - 1;
  for (std::ptrdiff_t i = 0; i <= last; ++i) {
    about_w.clear();
    for (std::ptrdiff_t j = std::max<std::ptrdiff_t>(i - kBeside, 0);
         j <= std::min(i + kBeside, last); ++j)
      about_w.push_back(blocks[static_cast<std::size_t>(j)].power_w);
    const PowerBlock& block = blocks[static_cast<std::size_t>(i)];
    levels.push_back({block.time_s, median_of(about_w)});
    sigmas_w.push_back(block.sigma_w);
  }
  sigma_w = sigmas_w.empty() ? 0.0 : median_of(sigmas_w);
  return levels;
}

}  // namespace

bool blocks_constant_light(const PowerTrace& trace) {
  constexpr double kMost = 0.6, kShare = 0.02, kShareOfOne = 0.05, kSeen_s = 1.5;
  if (trace.time_s.size() < 2) return false;
  double sigma_w = 0.0;
  const std::vector<Level> levels = levels_in(trace, sigma_w);
  if (levels.empty()) return false;
  const std::vector<std::size_t> vehicles = vehicles_in(levels);
  std::vector<Swing> swings;
  for (std::size_t k = 0; k < vehicles.size(); ++k) {
    const double next_s = k + 1 < vehicles.size() ? levels[vehicles[k + 1]].time_s : INFINITY;
    const double time_s = levels[vehicles[k]].time_s;
    if (time_s - levels.front().time_s > kSeen_s &&
        std::min(next_s, levels.back().time_s) - time_s > kSeen_s)
      swings.push_back(swing_after(levels, vehicles[k], next_s, sigma_w));
  }
  const double share = swings.size() == 1 ? kShareOfOne : kShare;
  const auto told = std::ranges::count_if(
      swings, [&](const Swing& swing) { return swing.back && swing.share > share; });
  return told > 0 && static_cast<double>(told) > kMost * static_cast<double>(swings.size());
}

}  // namespace vildar
