#include <algorithm>
#include <cmath>

#include "condition/coming_again.h"
#include "condition/condition.h"
#include "condition/noise.h"
#include "condition/sliding.h"

namespace vildar {
namespace {

constexpr double kBlock_s = 0.02;  // two periods of 100 Hz flicker
constexpr double kLeastSamples = 4.0;
constexpr double kSigmas = 6.0;
constexpr double kShareOfRange = 0.02;
constexpr double kRangeReach_s = 30.0;
constexpr double kFollowDownTo = 0.5;  // of the threshold
constexpr double kShortest_s = 0.1;
constexpr double kShortestDark_s = 0.3;
constexpr double kLongestGap_s = 1.0;
constexpr double kDeepMinimum = 0.4;  // of the lower maximum: pitching and beam patterns stay above

/// Blocks [first, last].
struct Stretch {
  std::size_t first = 0;
  std::size_t last = 0;
};

/// Blocks of a trace with what counts as light in them.
struct Light {
  std::vector<PowerBlock> blocks;
  std::vector<double> above_w;  ///< above ambient
  double sigma_w = 0.0;         ///< of one block in the dark, flicker included
  std::vector<double> threshold_w;
};

Light light_in(const PowerTrace& trace) {
  Light light;
  const double block_s = std::max(kBlock_s, kLeastSamples * trace.sample_period_s);
  light.blocks = block_means(trace, trace.time_s.front(),
                             trace.time_s.back() + 0.5 * trace.sample_period_s, block_s);
  if (light.blocks.empty()) return light;
  std::vector<double> sigmas_w;
  // Where it was never dark the ambient may be anything below the least light seen.
  const double least_w =
      std::min_element(light.blocks.begin(), light.blocks.end(), [](const auto& a, const auto& b) {
        return a.power_w < b.power_w;
      })->power_w;
  const double floor_w = std::max(trace.ambient_w, least_w);
  for (const PowerBlock& block : light.blocks) {
    light.above_w.push_back(block.power_w - floor_w);
    sigmas_w.push_back(block.sigma_w);
  }
  // Vehicles only add light, so what lies below ambient shows how far blocks scatter in the dark.
  constexpr double kLowest = 0.05;
  constexpr double kSigmasAtLowest = 1.6448536269514722;
  std::vector<double> sorted = light.above_w;
  const double scatter_w = -quantile_of(sorted, kLowest) / kSigmasAtLowest;
  light.sigma_w = std::max(median_of(sigmas_w), scatter_w);
  std::vector<double> times_s;
  for (const PowerBlock& block : light.blocks) times_s.push_back(block.time_s);
  light.threshold_w = sliding_maximum(times_s, light.above_w, kRangeReach_s);
  for (double& threshold_w : light.threshold_w)
    threshold_w = std::max(kSigmas * light.sigma_w, kShareOfRange * threshold_w);
  return light;
}

bool gap_before(const Light& light, std::size_t i) {
  return light.blocks[i].time_s - light.blocks[i - 1].time_s > kLongestGap_s;
}

std::vector<Stretch> stretches_of(const Light& light) {
  std::vector<Stretch> found;
  const auto low_w = [&](std::size_t i) { return kFollowDownTo * light.threshold_w[i]; };
  const std::size_t count = light.blocks.size();
  for (std::size_t i = 0; i < count; ++i) {
    if (!(light.above_w[i] > light.threshold_w[i])) continue;
    Stretch stretch{i, i};
    while (stretch.first > 0 && light.above_w[stretch.first - 1] > low_w(stretch.first - 1) &&
           !gap_before(light, stretch.first))
      --stretch.first;
    while (stretch.last + 1 < count && light.above_w[stretch.last + 1] > low_w(stretch.last + 1) &&
           !gap_before(light, stretch.last + 1))
      ++stretch.last;
    i = stretch.last;
    // What noise alone has parted is one again; where light falls deep, parts_of() cuts.
    const bool goes_on = !found.empty() && light.blocks[stretch.first].time_s -
                                                   light.blocks[found.back().last].time_s <
                                               kShortestDark_s;
    if (goes_on)
      found.back().last = stretch.last;
    else
      found.push_back(stretch);
  }
  return found;
}

std::size_t brightest_of(const Light& light, const Stretch& part) {
  const auto first = light.above_w.begin() + static_cast<std::ptrdiff_t>(part.first);
  const auto end = light.above_w.begin() + static_cast<std::ptrdiff_t>(part.last) + 1;
  return static_cast<std::size_t>(std::max_element(first, end) - light.above_w.begin());
}

/// The steepest fall of ln of the light within 0.06 s, after the brightest of a part.
double steepest_fall(const Light& light, const Stretch& part) {
  constexpr double kWithin_s = 0.06, kLeast = 0.01;  // of the brightest
  const double block_s = light.blocks[part.first].duration_s;
  const auto blocks = static_cast<std::size_t>(std::max(1.0, std::round(kWithin_s / block_s)));
  const auto at = [&](std::size_t i) { return light.above_w[i]; };
  const std::size_t brightest = brightest_of(light, part);
  const double least_w = std::max(kLeast * at(brightest), kSigmas * light.sigma_w);
  const std::size_t end = std::min(part.last + 1, light.blocks.size() - 1);
  double steepest = 0.0;
  for (std::size_t i = brightest; i < end; ++i)
    steepest = std::max(steepest, std::log(std::max(at(i), least_w) /
                                           std::max(at(std::min(i + blocks, end)), least_w)));
  return steepest;
}

/// Joins what a vehicle's own beam has parted: near a low photodiode the light falls as its cut-off
/// goes by, a tenth as steeply as lamps that go out of view do within 3 s.
void join_at_cut_offs(const Light& light, std::vector<Stretch>& parts) {
  constexpr double kGentle = 0.1, kLongest_s = 3.0;
  for (std::size_t next = parts.size() - 1; next > 0; --next) {
    Stretch& part = parts[next - 1];
    const double apart_s = light.blocks[brightest_of(light, parts[next])].time_s -
                           light.blocks[brightest_of(light, part)].time_s;
    if (apart_s > kLongest_s) continue;
    if (!(steepest_fall(light, part) < kGentle * steepest_fall(light, parts[next]))) continue;
    part.last = parts[next].last;
    parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(next));
  }
}

/// Cuts a stretch at every deep minimum; the minimum itself goes to the later part.
std::vector<Stretch> parts_of(const Light& light, Stretch whole) {
  std::vector<Stretch> parts;
  std::size_t first = whole.first, lowest = whole.first;
  double peak_w = light.above_w[whole.first];
  for (std::size_t i = whole.first + 1; i <= whole.last; ++i) {
    const double here_w = light.above_w[i];
    if (here_w < light.above_w[lowest]) lowest = i;
    const double lower_peak_w = std::min(peak_w, here_w);
    const double minimum_w = light.above_w[lowest];
    if (lowest > first && minimum_w < kDeepMinimum * lower_peak_w &&
        lower_peak_w - minimum_w > kSigmas * light.sigma_w) {
      parts.push_back({first, lowest - 1});
      first = lowest;
      peak_w = here_w;
      lowest = i;
    } else if (here_w > peak_w) {
      peak_w = here_w;
      lowest = i;
    }
  }
  parts.push_back({first, whole.last});
  join_at_cut_offs(light, parts);
  return parts;
}

/// Least light above ambient after block `peak`, when its vehicle is past: until it has not fallen
/// for a second or rises again, at most 3 s. A slow vehicle's own takes two to fade from a broad
/// beam, and its other lamp may rise for a moment when one has left the view.
double light_after_w(const Light& light, std::size_t peak) {
  constexpr double kPast_s = 1.0, kLatest_s = 3.0, kRise = 1.5, kSlightRise = 1.1;
  constexpr double kMoment_s = 0.3;
  std::size_t least = peak, last_low = peak;
  for (std::size_t i = peak;
       i < light.blocks.size() && light.blocks[i].time_s < light.blocks[least].time_s + kPast_s &&
       light.blocks[i].time_s < light.blocks[peak].time_s + kLatest_s;
       ++i) {
    const double noise_w = kSigmas * light.sigma_w;
    if (light.above_w[i] < light.above_w[least]) least = i;
    if (light.above_w[i] < kSlightRise * light.above_w[least] + noise_w) last_low = i;
    if (light.above_w[i] >= kRise * light.above_w[least] + noise_w ||
        light.blocks[i].time_s - light.blocks[last_low].time_s > kMoment_s)
      break;
  }
  return std::max(0.0, light.above_w[least]);
}

/// Whether the record ends, or stops for long, so soon after block `peak` that its vehicle need not
/// be past.
bool ends_after(const Light& light, std::size_t peak) {
  constexpr double kPassing_s = 0.3;
  const double until_s = light.blocks[peak].time_s + kPassing_s;
  for (std::size_t i = peak + 1; i < light.blocks.size() && !gap_before(light, i); ++i)
    if (light.blocks[i].time_s > until_s) return false;
  return true;
}

/// A part from its first block's beginning to its last one's end. Where stamps are uneven those are
/// not exact; the middle between two blocks is the limit, so that neighbours do not overlap.
PowerPass pass_of(const Light& light, Stretch part) {
  const auto middle_s = [&](std::size_t i) {
    return light.blocks[i - 1].time_s + 0.5 * (light.blocks[i].time_s - light.blocks[i - 1].time_s);
  };
  const PowerBlock& first = light.blocks[part.first];
  const PowerBlock& last = light.blocks[part.last];
  const std::size_t brightest = brightest_of(light, part);
  PowerPass pass{.from_s = first.time_s - 0.5 * first.duration_s,
                 .to_s = last.time_s + 0.5 * last.duration_s,
                 .peak_s = light.blocks[brightest].time_s};
  pass.cut_off = ends_after(light, brightest);
  if (!pass.cut_off) pass.others_w = light_after_w(light, brightest);
  if (part.first > 0) pass.from_s = std::max(pass.from_s, middle_s(part.first));
  if (part.last + 1 < light.blocks.size()) pass.to_s = std::min(pass.to_s, middle_s(part.last + 1));
  return pass;
}

}  // namespace

std::vector<PowerPass> find_passes(const PowerTrace& trace) {
  std::vector<PowerPass> passes;
  if (trace.time_s.size() < 2) return passes;
  const Light light = light_in(trace);
  if (light.blocks.empty()) return passes;
  for (const Stretch& whole : stretches_of(light)) {
    for (const Stretch& part : parts_of(light, whole)) {
      PowerPass pass = pass_of(light, part);
      pass.photodiode = trace.photodiode;
      if (pass.to_s - pass.from_s < kShortest_s) continue;
      pass.comes_again_s = comes_again_after_s(trace, pass.from_s, pass.to_s).value_or(0.0);
      passes.push_back(pass);
    }
  }
  return passes;
}

}  // namespace vildar
