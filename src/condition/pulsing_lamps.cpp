#include "condition/pulsing_lamps.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <numeric>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "condition/noise.h"

namespace vildar {
namespace {

constexpr double kWindow_s = 0.025;  // two periods of the slowest
constexpr double kMostGap = 1.5;     // periods of samples

/// Consecutive samples, of which every few are looked at.
struct Window {
  double low_w = 0.0, high_w = 0.0;
  bool clear = false;  ///< jumps up and down by far more than noise
  bool told = false;   ///< by more than enough to tell of each sample which level it is at

  double jump_w() const { return high_w - low_w; }
  double share(double power_w) const { return (power_w - low_w) / jump_w(); }
};

/// On from `on_s` + k periods for `duty` of each.
struct Rhythm {
  double on_s = 0.0, period_s = 0.0, duty = 0.0;

  double periods_at(double time_s) const { return (time_s - on_s) / period_s; }
};

/// Times at which light goes through the middle between its two levels.
struct Edges {
  std::vector<double> up_s, down_s;
};

struct Level {
  double time_s = 0.0, power_w = 0.0;
};

double phase_of(double periods) { return periods - std::floor(periods); }

/// All of a trace but what is left over at its end.
struct Windows {
  std::vector<Window> each;
  std::size_t samples = 0;  ///< of each

  const Window* at(std::size_t sample) const {
    return sample / samples < each.size() ? &each[sample / samples] : nullptr;
  }
};

Windows windows_of(const PowerTrace& trace, std::size_t samples) {
  constexpr std::size_t kEnough = 64;
  constexpr double kClearSigmas = 20.0, kToldSigmas = 12.0, kLeastSpread = 0.1;  // of the light
  const double dark_w = dark_level_w(trace.power_w);
  const std::size_t step = std::max<std::size_t>(1, samples / kEnough);
  Windows windows{std::vector<Window>(trace.power_w.size() / samples), samples};
  for (std::size_t k = 0; k < windows.each.size(); ++k) {
    const std::size_t first = k * samples, end = first + samples;
    double sum_w = 0.0, squares_w2 = 0.0;
    float low_w = trace.power_w[first], high_w = low_w;
    int count = 0;
    for (std::size_t i = first; i < end; i += step, ++count) {
      const float power_w = trace.power_w[i];
      sum_w += power_w;
      squares_w2 += static_cast<double>(power_w) * power_w;
      low_w = std::min(low_w, power_w);
      high_w = std::max(high_w, power_w);
    }
    const double mean_w = sum_w / count;
    const bool whole = trace.time_s[end - 1] - trace.time_s[first] <
                       kMostGap * static_cast<double>(samples) * trace.sample_period_s;
    const double jump_w = high_w - low_w;
    const bool jumps = whole && squares_w2 / count - mean_w * mean_w >
                                    std::pow(kLeastSpread * (mean_w - dark_w), 2);
    windows.each[k] = {low_w, high_w, jumps && jump_w > kClearSigmas * trace.noise_sigma_w,
                       jumps && jump_w > kToldSigmas * trace.noise_sigma_w};
  }
  return windows;
}

/// Of windows [first, end).
Edges edges_of(const PowerTrace& trace, const Windows& windows, std::size_t first,
               std::size_t end) {
  constexpr double kNear = 0.35;  // of the jump: nearer to a level is there
  Edges edges;
  std::optional<bool> on;
  std::size_t last = 0;  // sample surely at the level before
  for (std::size_t i = first * windows.samples; i < end * windows.samples; ++i) {
    const Window& window = *windows.at(i);
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

/// Line through edges [first, end) against their numbers as `rhythm` counts them; nothing where
/// they do not lie on one.
std::optional<Rhythm> line_through(std::span<const double> edges_s, const Rhythm& rhythm,
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
  const Rhythm line{rhythm.on_s + (sum_t - period_s * sum_k) / n, period_s, rhythm.duty};
  double squares_s2 = 0.0;
  for (const double edge_s : edges_s)
    squares_s2 += std::pow(edge_s - line.on_s - number_of(edge_s) * period_s, 2);
  const double numbers = number_of(edges_s.back()) - number_of(edges_s.front()) + 1.0;
  const bool straight =
      std::sqrt(squares_s2 / n) < kSampleDoubt * sample_s + kPeriodDoubt * period_s;
  return straight && n > kFewestOfAll * numbers ? std::optional(line) : std::nullopt;
}

/// What is of one vehicle.
struct Stretch {
  Rhythm rhythm;
  double from_s = 0.0, to_s = 0.0;  ///< where its edges were seen
};

/// From the edge nearest to `middle_s` as far as edges keep to one line.
std::optional<Stretch> stretch_about(double middle_s, const Edges& edges, double sample_s) {
  constexpr std::ptrdiff_t kFirst = 12;
  constexpr double kWiden = 0.25, kMostSlips = 0.1, kMostSamples = 1.25, kMostPeriods = 0.03;
  const auto& up_s = edges.up_s;
  const auto n = static_cast<std::ptrdiff_t>(up_s.size());
  if (n < kFirst) return std::nullopt;
  const std::ptrdiff_t middle = std::ranges::lower_bound(up_s, middle_s) - up_s.begin();
  std::optional<Rhythm> best;
  Stretch stretch;
  // A vehicle may be gone at once when it is brightest.
  for (const std::ptrdiff_t before : {kFirst / 2, kFirst, std::ptrdiff_t{0}}) {
    std::ptrdiff_t from = std::clamp<std::ptrdiff_t>(middle - before, 0, n - kFirst);
    std::ptrdiff_t to = from + kFirst;
    const double first_s = up_s[static_cast<std::size_t>(from)];
    Rhythm rhythm{first_s, (up_s[static_cast<std::size_t>(to - 1)] - first_s) / (kFirst - 1), 0.0};
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
  for (const double down_s : edges.down_s)
    if (down_s >= stretch.from_s && down_s <= stretch.to_s + best->period_s)
      duties.push_back(phase_of(best->periods_at(down_s)));
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

double at_time(const std::vector<Level>& levels, std::size_t& next, double time_s) {
  while (next < levels.size() && levels[next].time_s < time_s) ++next;
  if (next == 0) return levels.front().power_w;
  if (next == levels.size()) return levels.back().power_w;
  const Level &a = levels[next - 1], &b = levels[next];
  return std::lerp(a.power_w, b.power_w, (time_s - a.time_s) / (b.time_s - a.time_s));
}

/// Samples [first, end) of a trace, by turns on and off.
class Turns {
 public:
  Turns(PowerTrace& trace, const Windows& windows, const Rhythm& rhythm, std::size_t first,
        std::size_t end)
      : trace_(trace),
        windows_(windows),
        rhythm_(rhythm),
        first_(first),
        end_(end),
        per_period_(rhythm.period_s * static_cast<double>(end - first - 1) /
                    (trace.time_s[end - 1] - trace.time_s[first])) {}

  /// In a period; of the shorter turn.
  double samples_per_turn() const {
    return per_period_ * std::min(rhythm_.duty, 1.0 - rhythm_.duty);
  }
  double samples_per_period() const { return per_period_; }
  double duty() const { return rhythm_.duty; }

  /// How far edges that fall always into the same part of a sample leave the duty unknown: of one
  /// sample's width where all do, and of a fraction of it where they fall into few parts.
  double duty_std() const {
    constexpr double kOfTwoEdges = 0.41;  // sqrt(2 / 12)
    constexpr int kParts = 4;
    const double sample_s = rhythm_.period_s / per_period_;
    double most = 0.0;
    for (int parts = 1; parts <= kParts; ++parts) {
      std::complex<double> sum;
      double count = 0.0;
      for (double edge_s = rhythm_.on_s; edge_s < trace_.time_s[end_ - 1];
           edge_s += rhythm_.period_s, ++count)
        sum += std::polar(1.0, 2.0 * std::numbers::pi * parts * (edge_s - rhythm_.on_s) / sample_s);
      most = std::max(most, std::abs(sum) / std::max(count, 1.0) / parts);
    }
    return kOfTwoEdges * most / per_period_;
  }

  /// In the place of each sample the mean of both levels, weighed by their time. `margin` of a
  /// period about the edges belongs to neither; with `by_value` that goes for samples whose level
  /// is not told alone. False, and nothing done, where a level is not seen.
  bool put_levels(double margin, bool by_value) {
    const auto turn_of = [&](std::size_t i, double phase) {
      const Window* window = windows_.at(i);
      if (by_value && window && window->told)
        return window->share(trace_.power_w[i]) > 0.5 ? Turn::on : Turn::off;
      if (phase > margin && phase < rhythm_.duty - margin) return Turn::on;
      return phase > rhythm_.duty + margin && phase < 1.0 - margin ? Turn::off : Turn::neither;
    };
    const std::vector<Level> on = levels(Turn::on, turn_of);
    const std::vector<Level> off = levels(Turn::off, turn_of);
    if (on.empty() || off.empty()) return false;
    std::size_t next_on = 0, next_off = 0;
    for (std::size_t i = first_; i < end_; ++i) {
      const double time_s = trace_.time_s[i];
      trace_.power_w[i] = static_cast<float>(
          std::lerp(at_time(off, next_off, time_s), at_time(on, next_on, time_s), rhythm_.duty));
    }
    return true;
  }

  /// In the place of each sample the mean over the period about it; samples fill their spacing.
  void put_means() {
    std::vector<double> sums_w{0.0};
    for (std::size_t i = first_; i < end_; ++i) sums_w.push_back(sums_w.back() + trace_.power_w[i]);
    const auto sum_to = [&](double place) {
      const auto whole = std::min(static_cast<std::size_t>(place), sums_w.size() - 2);
      return std::lerp(sums_w[whole], sums_w[whole + 1], place - static_cast<double>(whole));
    };
    for (std::size_t i = first_; i < end_; ++i) {
      const double middle = static_cast<double>(i - first_) + 0.5;
      const double from = middle - 0.5 * per_period_, to = middle + 0.5 * per_period_;
      if (from < 0.0 || to > static_cast<double>(end_ - first_)) continue;
      trace_.power_w[i] = static_cast<float>((sum_to(to) - sum_to(from)) / per_period_);
    }
  }

 private:
  enum class Turn { on, off, neither };

  /// Means of the samples of each such turn.
  std::vector<Level> levels(Turn turn, const auto& turn_of) const {
    std::vector<Level> levels;
    double number = NAN, sum_s = 0.0, sum_w = 0.0, count = 0.0;
    const auto close = [&] {
      if (count > 0.0) levels.push_back({sum_s / count, sum_w / count});
      sum_s = sum_w = count = 0.0;
    };
    for (std::size_t i = first_; i < end_; ++i) {
      const double periods = rhythm_.periods_at(trace_.time_s[i]), phase = phase_of(periods);
      if (turn_of(i, phase) != turn) continue;
      if (std::floor(periods) != number) close();
      number = std::floor(periods);
      sum_s += trace_.time_s[i];
      sum_w += trace_.power_w[i];
      count += 1.0;
    }
    close();
    return levels;
  }

  PowerTrace& trace_;
  const Windows& windows_;
  Rhythm rhythm_;
  std::size_t first_, end_;
  double per_period_;
};

using Range = std::pair<std::size_t, std::size_t>;  // from the first to before the last

/// Share of samples between the levels.
double share_between(const PowerTrace& trace, const Windows& windows, const Range& seen) {
  constexpr double kNear = 0.2;  // of the jump
  double between = 0.0, all = 0.0;
  for (std::size_t i = seen.first * windows.samples; i < seen.second * windows.samples; ++i) {
    const Window& window = *windows.at(i);
    if (!window.clear) continue;
    const double share = window.share(trace.power_w[i]);
    between += share > kNear && share < 1.0 - kNear;
    all += 1.0;
  }
  return between / all;
}

/// The samples whose light the stretch tells: 3 s beyond where its edges are seen, but not into
/// others' pulses or over a gap.
Range reach_of(const Stretch& stretch, const PowerTrace& trace, const Windows& windows,
               const Range& seen) {
  constexpr double kBeyond_s = 3.0;
  const auto ends_at = [&](std::size_t i) {
    const Window* window = windows.at(i);
    const std::size_t k = i / windows.samples;
    return trace.time_s[i] - trace.time_s[i - 1] > kMostGap * trace.sample_period_s ||
           (window && window->clear && (k < seen.first || k >= seen.second));
  };
  Range reach{seen.first * windows.samples + 1, seen.second * windows.samples};
  while (reach.first > 1 && !ends_at(reach.first - 1) &&
         stretch.from_s - trace.time_s[reach.first - 1] < kBeyond_s)
    --reach.first;
  while (reach.second < trace.time_s.size() && !ends_at(reach.second) &&
         trace.time_s[reach.second] - stretch.to_s < kBeyond_s)
    ++reach.second;
  return {reach.first - 1, reach.second};
}

/// Evens out; gives the doubt about the duty, and nothing where the light cannot be told.
std::optional<double> put_mean_light(Turns& turns, double share_between_levels) {
  constexpr double kFewest = 0.95, kMany = 3.0;  // samples of a turn
  constexpr double kFewestOfPeriod = 3.0;
  constexpr double kEdges = 1.2, kMostBetween = 0.15, kAverages = 0.5;
  const double period = turns.samples_per_period(), turn = turns.samples_per_turn();
  if (period < kFewestOfPeriod || turn < kFewest ||
      share_between_levels > kEdges / period + kMostBetween)
    return std::nullopt;
  const bool averages = share_between_levels > kAverages * kEdges / period;
  if (averages && turn < kMany) {
    turns.put_means();
    return 0.0;
  }
  const bool few = turn < kMany;
  const double margin =
      few ? 0.15 / period
          : std::max(0.5 / period, 0.15 * std::min(turns.duty(), 1.0 - turns.duty()));
  if (!turns.put_levels(margin, few)) return std::nullopt;
  return averages ? 0.0 : turns.duty_std();
}

}  // namespace

void even_out_pulses(PowerTrace& trace) {
  constexpr std::size_t kFewestWindows = 12, kMostBetween = 10;
  if (trace.power_w.empty() || !(trace.sample_period_s > 0.0)) return;
  const auto samples = std::max<std::size_t>(
      8, static_cast<std::size_t>(std::lround(kWindow_s / trace.sample_period_s)));
  const Windows windows = windows_of(trace, samples);
  const std::vector<Window>& each = windows.each;
  std::vector<Range> left;
  for (std::size_t first = 0, end = 1; first < each.size(); first = end) {
    end = first + 1;
    if (!each[first].clear) continue;
    for (std::size_t i = end; i < each.size() && i - end < kMostBetween; ++i)
      if (each[i].clear) end = i + 1;
    left.emplace_back(first, end);
  }
  const auto window_at = [&](double time_s) {
    return static_cast<std::size_t>(std::ranges::lower_bound(trace.time_s, time_s) -
                                    trace.time_s.begin()) /
           samples;
  };
  // Of what pulses on end, first what the brightest vehicle lights, then the rest.
  while (!left.empty()) {
    const auto [first, end] = left.back();
    left.pop_back();
    if (end < first + kFewestWindows) continue;
    const auto brightest =
        std::max_element(each.begin() + static_cast<std::ptrdiff_t>(first),
                         each.begin() + static_cast<std::ptrdiff_t>(end),
                         [](const Window& a, const Window& b) { return a.jump_w() < b.jump_w(); });
    const auto middle = static_cast<std::size_t>(brightest - each.begin()) * samples + samples / 2;
    const auto stretch = stretch_about(trace.time_s[middle], edges_of(trace, windows, first, end),
                                       trace.sample_period_s);
    if (!stretch) continue;
    const Range seen{std::max(first, window_at(stretch->from_s)),
                     std::min(end, window_at(stretch->to_s) + 1)};
    left.emplace_back(first, seen.first);
    left.emplace_back(seen.second, end);
    const Range reach = reach_of(*stretch, trace, windows, seen);
    const Rhythm& rhythm = stretch->rhythm;
    Turns turns(trace, windows, rhythm, reach.first, reach.second);
    if (const auto duty_std = put_mean_light(turns, share_between(trace, windows, seen)))
      trace.pulsing.push_back({trace.time_s[reach.first], trace.time_s[reach.second - 1],
                               1.0 / rhythm.period_s, rhythm.duty, *duty_std});
  }
  std::ranges::sort(trace.pulsing, {}, &PulsingLight::from_s);
}

}  // namespace vildar
