#include "condition/pulse_rhythm.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "condition/noise.h"

namespace vildar {
namespace {

constexpr double kWindow_s = 0.025;  // two periods of the slowest
constexpr std::size_t kFewestSamples = 8;

PulseWindow window_of(const PowerTrace& trace, std::size_t first, std::size_t samples,
                      double dark_w) {
  constexpr std::size_t kEnough = 64;
  constexpr std::uint32_t kGolden = 2654435769;  // of 2^32, the golden section
  constexpr double kClearSigmas = 20.0, kToldSigmas = 12.0, kLeastSpread = 0.1;  // of the light
  const std::size_t step = std::max<std::size_t>(1, samples / kEnough);
  double sum_w = 0.0, squares_w2 = 0.0;
  float low_w = trace.power_w[first], high_w = low_w;
  int count = 0;
  std::uint32_t turned = 0;
  for (std::size_t k = 0; k + step <= samples; k += step, ++count, turned += kGolden) {
    const float power_w = trace.power_w[first + k + (std::uint64_t{turned} * step >> 32)];
    sum_w += power_w;
    squares_w2 += static_cast<double>(power_w) * power_w;
    low_w = std::min(low_w, power_w);
    high_w = std::max(high_w, power_w);
  }
  const double mean_w = sum_w / count;
  PulseWindow window{low_w, high_w};
  window.whole = trace.time_s[first + samples - 1] - trace.time_s[first] <
                 (static_cast<double>(samples) - 0.5) * trace.sample_period_s;
  const bool jumps = window.whole && squares_w2 / count - mean_w * mean_w >
                                         std::pow(kLeastSpread * (mean_w - dark_w), 2);
  window.clear = jumps && window.jump_w() > kClearSigmas * trace.noise_sigma_w;
  window.told = jumps && window.jump_w() > kToldSigmas * trace.noise_sigma_w;
  return window;
}

/// Line through edges [first, end) against their numbers as `rhythm` counts them; nothing where
/// they do not lie on one.
std::optional<PulseRhythm> line_through(std::span<const double> edges_s, const PulseRhythm& rhythm,
                                        double sample_s) {
  constexpr double kSampleDoubt = 0.45, kPeriodDoubt = 0.02, kFewestOfAll = 0.9;
  double sum_k = 0.0, sum_kk = 0.0, sum_t = 0.0, sum_kt = 0.0;
  const auto n = static_cast<double>(edges_s.size());
  const auto number_of = [&](double edge_s) { return std::round(rhythm.periods_at(edge_s)); };
  for (const double edge_s : edges_s) {
    const double k = number_of(edge_s), t = edge_s - rhythm.on_s;
    sum_k += k;
    sum_kk += k * k;
    sum_t += t;
    sum_kt += k * t;
  }
  const double spread = sum_kk - sum_k * sum_k / n;
  if (!(spread > 0.0)) return std::nullopt;
  const double period_s = (sum_kt - sum_k * sum_t / n) / spread;
  const PulseRhythm line{rhythm.on_s + (sum_t - period_s * sum_k) / n, period_s, rhythm.duty};
  double squares_s2 = 0.0;
  for (const double edge_s : edges_s)
    squares_s2 += std::pow(edge_s - line.on_s - number_of(edge_s) * period_s, 2);
  const double numbers = number_of(edges_s.back()) - number_of(edges_s.front()) + 1.0;
  const bool straight =
      std::sqrt(squares_s2 / n) < kSampleDoubt * sample_s + kPeriodDoubt * period_s;
  return straight && n > kFewestOfAll * numbers ? std::optional(line) : std::nullopt;
}

/// Correlation of one step with the next, of means over a millisecond: of noise -0.5 even on a
/// slope, of a wave greater.
std::optional<double> step_correlation(std::span<const float> power_w) {
  constexpr std::size_t kMeans = 25;
  const std::size_t samples = std::max<std::size_t>(1, power_w.size() / kMeans);
  std::vector<double> steps_w;
  double last_w = 0.0, mean_step_w = 0.0;
  for (std::size_t first = 0; first + samples <= power_w.size(); first += samples) {
    const auto mean = power_w.subspan(first, samples);
    const double mean_w =
        std::accumulate(mean.begin(), mean.end(), 0.0) / static_cast<double>(samples);
    if (first > 0) steps_w.push_back(mean_w - last_w);
    last_w = mean_w;
  }
  for (const double step_w : steps_w) mean_step_w += step_w / static_cast<double>(steps_w.size());
  double square_w2 = 0.0, product_w2 = 0.0;
  for (std::size_t i = 0; i < steps_w.size(); ++i) {
    square_w2 += std::pow(steps_w[i] - mean_step_w, 2);
    if (i > 0) product_w2 += (steps_w[i] - mean_step_w) * (steps_w[i - 1] - mean_step_w);
  }
  return square_w2 > 0.0 ? std::optional(product_w2 / square_w2) : std::nullopt;
}

}  // namespace

double PulseWindows::waves_w(const PowerTrace& trace) const {
  constexpr std::size_t kEnough = 400;
  // Of noise -0.5, of light by the steps of a converter 0, of a wave of the mains 0.7 and more.
  const double white = trace.rounding_sigma_w > 0.0 ? 0.2 : -0.25;
  std::vector<double> correlations, ranges_w;
  for (std::size_t k = 0; k < each.size(); k += each.size() / kEnough + 1) {
    if (each[k].clear || !each[k].whole) continue;
    correlations.push_back(
        step_correlation({trace.power_w.data() + k * samples, samples}).value_or(-0.5));
    ranges_w.push_back(each[k].jump_w());
  }
  return correlations.empty() || median_of(correlations) < white ? 0.0 : median_of(ranges_w);
}

PulseWindows pulse_windows(const PowerTrace& trace) {
  PulseWindows windows;
  windows.samples = std::max(
      kFewestSamples, static_cast<std::size_t>(std::lround(kWindow_s / trace.sample_period_s)));
  const double dark_w = dark_level_w(trace.power_w);
  windows.each.reserve(trace.power_w.size() / windows.samples);
  for (std::size_t first = 0; first + windows.samples <= trace.power_w.size();
       first += windows.samples)
    windows.each.push_back(window_of(trace, first, windows.samples, dark_w));
  return windows;
}

PulseEdges pulse_edges(const PowerTrace& trace, const PulseWindows& windows, std::size_t first,
                       std::size_t end) {
  constexpr double kNear = 0.35;  // of the jump: nearer to a level is there
  PulseEdges edges;
  std::optional<bool> on;
  std::size_t last = 0;  // sample surely at the level before
  for (std::size_t i = first * windows.samples; i < end * windows.samples; ++i) {
    const PulseWindow& window = *windows.at(i);
    if (!window.clear) {
      on.reset();
      continue;
    }
    const double share = window.share(trace.power_w[i]);
    const bool high = share > 1.0 - kNear;
    if (!high && share > kNear) continue;
    if (on && *on != high) {
      const double middle_w = 0.5 * (window.low_w + window.high_w);
      std::size_t before = last;
      while (before + 1 < i && (trace.power_w[before + 1] < middle_w) == high) ++before;
      const double from_w = trace.power_w[before], to_w = trace.power_w[before + 1];
      const double part = std::clamp((middle_w - from_w) / (to_w - from_w), 0.0, 1.0);
      (high ? edges.up_s : edges.down_s)
          .push_back(std::lerp(trace.time_s[before], trace.time_s[before + 1], part));
    }
    on = high;
    last = i;
  }
  return edges;
}

std::optional<PulseStretch> stretch_about(double middle_s, std::span<const double> up_s,
                                          std::span<const double> down_s, double sample_s) {
  constexpr std::ptrdiff_t kFirst = 12;
  constexpr double kWiden = 0.25, kMostSlips = 0.1, kMostSamples = 1.25, kMostPeriods = 0.03;
  const auto n = static_cast<std::ptrdiff_t>(up_s.size());
  if (n < kFirst) return std::nullopt;
  const std::ptrdiff_t middle = std::ranges::lower_bound(up_s, middle_s) - up_s.begin();
  std::optional<PulseRhythm> best;
  PulseStretch stretch;
  // A vehicle may be gone at once when it is brightest.
  for (const std::ptrdiff_t before : {kFirst / 2, kFirst, std::ptrdiff_t{0}}) {
    std::ptrdiff_t from = std::clamp<std::ptrdiff_t>(middle - before, 0, n - kFirst);
    std::ptrdiff_t to = from + kFirst;
    const double first_s = up_s[static_cast<std::size_t>(from)];
    PulseRhythm rhythm{first_s, (up_s[static_cast<std::size_t>(to - 1)] - first_s) / (kFirst - 1),
                       0.0};
    for (bool more = true; more;) {
      const std::span<const double> part(up_s.begin() + from, up_s.begin() + to);
      const auto line = line_through(part, rhythm, sample_s);
      if (!line) break;
      best = rhythm = *line;
      stretch.from_s = part.front();
      stretch.to_s = part.back();
      const auto wider =
          static_cast<std::ptrdiff_t>(std::ceil(kWiden * static_cast<double>(to - from)));
      more = from > 0 || to < n;
      from = std::max<std::ptrdiff_t>(0, from - wider);
      to = std::min(n, to + wider);
    }
    if (best) break;
  }
  if (!best) return std::nullopt;
  std::vector<double> duties;
  for (const double one_s : down_s)
    if (one_s >= stretch.from_s && one_s <= stretch.to_s + best->period_s)
      duties.push_back(PulseRhythm::phase_of(best->periods_at(one_s)));
  if (duties.empty()) return std::nullopt;
  const double middle_duty = median_of(duties);
  const double reach = (kMostSamples * sample_s + kMostPeriods * best->period_s) / best->period_s;
  const auto before = static_cast<double>(duties.size());
  std::erase_if(duties, [&](double duty) { return std::abs(duty - middle_duty) > reach; });
  const auto kept = static_cast<double>(duties.size());
  if (kept < (1.0 - kMostSlips) * before) return std::nullopt;
  best->duty = std::accumulate(duties.begin(), duties.end(), 0.0) / kept;
  stretch.rhythm = *best;
  return stretch;
}

}  // namespace vildar
