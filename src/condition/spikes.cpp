#include "condition/spikes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "condition/noise.h"
#include "condition/sample_ranges.h"

namespace vildar {
namespace {

constexpr float kSpikeSigmas = 12.0F, kShareOfLight = 1.0F / 3.0F, kChanges = 2.0F;
constexpr std::ptrdiff_t kWidest = 2;  // samples

std::vector<SampleRange> spikes_in(const PowerTrace& trace) {
  const std::vector<float>& power_w = trace.power_w;
  const auto n = static_cast<std::ptrdiff_t>(power_w.size());
  const float noise_w = kSpikeSigmas * static_cast<float>(trace.noise_sigma_w);
  const float dark_w = dark_level_w(power_w);
  const float* at = power_w.data();
  std::vector<SampleRange> found;
  for (std::ptrdiff_t i = 2; i + 2 < n; ++i) {
    // Most samples are within noise of the one before.
    if (std::abs(at[i] - at[i - 1]) < noise_w) continue;
    for (std::ptrdiff_t width = 1; width <= kWidest && i + width + 1 < n; ++width) {
      const float before_w = at[i - 1], after_w = at[i + width];
      const auto [least, most] = std::minmax_element(at + i, at + i + width);
      const float over_w = *least - std::max(before_w, after_w);
      const float under_w = std::min(before_w, after_w) - *most;
      const float changes_w =
          std::max(std::abs(before_w - at[i - 2]), std::abs(at[i + width + 1] - after_w));
      const float light_w = std::max(0.0F, std::max(before_w, after_w) - dark_w);
      if (!(std::max(over_w, under_w) > noise_w + kShareOfLight * light_w + kChanges * changes_w))
        continue;
      found.push_back({static_cast<std::size_t>(i), static_cast<std::size_t>(width)});
      i += width;
      break;
    }
  }
  return found;
}

/// Leaves those that have too many others near, and all near such: where the lamps are dim, few of
/// their pulses stand out.
void leave_pulses(const PowerTrace& trace, std::vector<SampleRange>& spikes) {
  constexpr double kWithin_s = 0.25, kShare = 0.05, kFew = 3.0, kAbout_s = 2.0;
  const double most = std::max(kFew, kShare * kWithin_s / trace.sample_period_s);
  const auto time_s = [&](std::size_t k) { return trace.time_s[spikes[k].first]; };
  std::vector<bool> pulse(spikes.size(), false);
  for (std::size_t first = 0, last = 0; last < spikes.size(); ++last) {
    while (time_s(last) - time_s(first) > kWithin_s) ++first;
    if (static_cast<double>(last - first + 1) > most)
      std::fill(pulse.begin() + static_cast<std::ptrdiff_t>(first),
                pulse.begin() + static_cast<std::ptrdiff_t>(last) + 1, true);
  }
  std::vector<SampleRange> kept;
  double pulsed_s = -INFINITY;
  std::size_t next = 0;
  for (std::size_t k = 0; k < spikes.size(); ++k) {
    if (pulse[k]) pulsed_s = time_s(k);
    for (next = std::max(next, k); next < spikes.size() && !pulse[next];) ++next;
    const double next_s = next < spikes.size() ? time_s(next) : INFINITY;
    if (time_s(k) - pulsed_s > kAbout_s && next_s - time_s(k) > kAbout_s) kept.push_back(spikes[k]);
  }
  spikes = std::move(kept);
}

}  // namespace

std::int64_t drop_spikes(PowerTrace& trace) {
  if (trace.power_w.empty() || !(trace.noise_sigma_w > 0.0) || !(trace.sample_period_s > 0.0))
    return 0;
  std::vector<SampleRange> spikes = spikes_in(trace);
  leave_pulses(trace, spikes);
  return drop_ranges(trace, spikes);
}

}  // namespace vildar
