#include "condition/flashes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <optional>
#include <vector>

#include "condition/noise.h"
#include "condition/sample_ranges.h"

namespace vildar {
namespace {

constexpr double kFlashSigmas = 12.0;
constexpr double kLongest_s = 0.5, kRise_s = 1e-3, kStep_s = 4e-3;

/// Light that comes up at once and goes again.
struct Flash {
  SampleRange samples;
  double height_w = 0.0;
  bool fades = false;  ///< from the first; what is on for a while and then off is a lamp
};

/// One trace, with what a flash is looked for by.
class Looks {
 public:
  explicit Looks(const PowerTrace& trace)
      : trace_(trace),
        dark_w_(dark_level_w(trace.power_w)),
        jump_w_(kFlashSigmas * trace.noise_sigma_w),
        rise_(samples_in(kRise_s, 2)),
        step_(samples_in(kStep_s, 1)) {}

  /// The flash that begins with sample i > 0.
  std::optional<Flash> flash_at(std::size_t i) const {
    constexpr double kBackTo = 0.1, kLateToEarly = 0.4;  // of its height
    constexpr double kMostGap = 4.0;                     // periods
    const std::size_t last = std::min(i + samples_in(kLongest_s, 4), trace_.power_w.size());
    if (trace_.time_s[i] - trace_.time_s[i - 1] > kMostGap * trace_.sample_period_s)
      return std::nullopt;
    const double before_w = mean_w(i - std::min(i, step_), i);
    const double height_w = *std::max_element(at(i), at(std::min(i + rise_, last))) - before_w;
    if (height_w < std::max(jump_w_, before_w - dark_w_)) return std::nullopt;
    const auto end = end_of_fall(i, last, before_w);
    if (!end || mean_w(*end, *end + step_) - before_w > kBackTo * height_w ||
        trace_.time_s[*end] - trace_.time_s[i] > kLongest_s)
      return std::nullopt;
    const std::size_t half = i + (*end - i) / 2;
    const bool fades =
        half == i || mean_w(half, *end) - before_w < kLateToEarly * (mean_w(i, half) - before_w);
    // The rest of its fading is hidden in other light.
    const double until_s = 2.0 * trace_.time_s[*end] - trace_.time_s[i];
    std::size_t until = *end;
    while (until < trace_.power_w.size() && trace_.time_s[until] < until_s) ++until;
    return Flash{{i, until - i}, height_w, fades};
  }
  bool jumps_at(std::size_t i) const {
    return trace_.power_w[i] - trace_.power_w[i - 1] > 0.5 * jump_w_;  // of two
  }

 private:
  /// First sample at which light falls no more, or is back to what it was, if it goes on falling.
  std::optional<std::size_t> end_of_fall(std::size_t first, std::size_t last,
                                         double before_w) const {
    constexpr double kFlat = 0.01, kFlashesAgain = 1.5;
    const double noise_w = 3.0 * trace_.noise_sigma_w / std::sqrt(static_cast<double>(step_));
    std::optional<std::size_t> back;
    for (std::size_t i = first + rise_; i + 2 * step_ <= last; i += step_) {
      const double now_w = mean_w(i, i + step_), next_w = mean_w(i + step_, i + 2 * step_);
      const double light_w = std::max(now_w - dark_w_, 0.0);
      const bool falls = next_w < now_w - noise_w - kFlat * light_w;
      const bool again = next_w - dark_w_ > kFlashesAgain * light_w + jump_w_;
      if (!falls && !again) return i;
      if (!back && now_w < before_w + noise_w) back = i;
    }
    return back;
  }
  std::size_t samples_in(double duration_s, std::size_t least) const {
    return std::max(least,
                    static_cast<std::size_t>(std::lround(duration_s / trace_.sample_period_s)));
  }
  const float* at(std::size_t i) const { return trace_.power_w.data() + i; }
  double mean_w(std::size_t first, std::size_t end) const {
    return std::accumulate(at(first), at(end), 0.0) /
           static_cast<double>(std::max<std::size_t>(1, end - first));
  }

  const PowerTrace& trace_;
  double dark_w_, jump_w_;
  std::size_t rise_, step_;
};

/// From one sample to the next.
struct Jump {
  std::size_t sample = 0;
  double rise_w = 0.0;
};

constexpr double kWithin_s = 3.0;
constexpr std::size_t kMost = 5;

/// Whether light about the flash, but not within it, jumps again and again by about as much, as of
/// lamps that pulse.
bool among_pulses(const PowerTrace& trace, const Flash& flash, const std::vector<Jump>& jumps) {
  constexpr double kAbout = 0.3;
  const auto [first, count] = flash.samples;
  const double from_s = trace.time_s[first] - kWithin_s, to_s = trace.time_s[first] + kWithin_s;
  std::size_t alike = 0;
  auto jump = std::ranges::lower_bound(jumps, from_s, {},
                                       [&](const Jump& one) { return trace.time_s[one.sample]; });
  for (; jump != jumps.end() && trace.time_s[jump->sample] < to_s && alike <= kMost; ++jump)
    alike += (jump->sample < first || jump->sample >= first + count) &&
                     jump->rise_w > kAbout * flash.height_w
                 ? 1
                 : 0;
  return alike > kMost;
}

/// Those that fade, of which there are no more than a few near, with what does not fade.
std::vector<SampleRange> single(const PowerTrace& trace, const std::vector<Flash>& flashes,
                                const std::vector<Jump>& jumps) {
  const auto time_s = [&](std::size_t k) { return trace.time_s[flashes[k].samples.first]; };
  std::vector<char> series(flashes.size(), 0);
  for (std::size_t first = 0, last = 0; last < flashes.size(); ++last) {
    while (time_s(last) - time_s(first) > kWithin_s) ++first;
    if (last - first + 1 > kMost)
      for (std::size_t k = first; k <= last; ++k) series[k] = 1;
  }
  std::vector<SampleRange> kept;
  for (std::size_t k = 0; k < flashes.size(); ++k)
    if (!series[k] && flashes[k].fades && !among_pulses(trace, flashes[k], jumps))
      kept.push_back(flashes[k].samples);
  return kept;
}

}  // namespace

std::int64_t drop_flashes(PowerTrace& trace) {
  if (trace.power_w.empty() || !(trace.noise_sigma_w > 0.0) || !(trace.sample_period_s > 0.0))
    return 0;
  const Looks looks(trace);
  std::vector<Flash> flashes;
  std::vector<Jump> jumps;
  for (std::size_t i = 1; i < trace.power_w.size(); ++i) {
    if (!looks.jumps_at(i)) continue;
    jumps.push_back({i, static_cast<double>(trace.power_w[i]) - trace.power_w[i - 1]});
    if (const auto flash = looks.flash_at(i)) {
      flashes.push_back(*flash);
      i += flash->samples.count - 1;
    }
  }
  return drop_ranges(trace, single(trace, flashes, jumps));
}

}  // namespace vildar
