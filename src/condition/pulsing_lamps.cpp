#include "condition/pulsing_lamps.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "condition/flicker.h"
#include "condition/noise.h"
#include "condition/pulse_rhythm.h"

namespace vildar {
namespace {

struct Brightness {
  double time_s = 0.0, power_w = 0.0;
  double rise_w = 0.0;  ///< of its last sample over its first
  int samples = 0;
};

constexpr std::size_t kFewestWindows = 12;

double at_time(const std::vector<Brightness>& levels, std::size_t& next, double time_s) {
  while (next < levels.size() && levels[next].time_s < time_s) ++next;
  if (next == 0) return levels.front().power_w;
  if (next == levels.size()) return levels.back().power_w;
  const Brightness &a = levels[next - 1], &b = levels[next];
  return std::lerp(a.power_w, b.power_w, (time_s - a.time_s) / (b.time_s - a.time_s));
}

using Range = std::pair<std::size_t, std::size_t>;  // from the first to before the last

/// Samples of a trace, by turns on and off.
class Turns {
 public:
  Turns(PowerTrace& trace, const PulseWindows& windows, const PulseStretch& stretch, Range range)
      : trace_(trace),
        windows_(windows),
        stretch_(stretch),
        rhythm_(stretch.rhythm),
        first_(range.first),
        end_(range.second),
        per_period_(rhythm_.period_s * static_cast<double>(end_ - first_ - 1) /
                    (trace.time_s[end_ - 1] - trace.time_s[first_])) {}

  double samples_per_period() const { return per_period_; }
  /// Of the shorter turn.
  double samples_per_turn() const {
    return per_period_ * std::min(rhythm_.duty, 1.0 - rhythm_.duty);
  }

  /// How far edges that fall always into the same part of a sample leave the duty unknown: of one
  /// sample's width where all do, and of less where they move through it, or fall into few parts.
  double duty_std() const {
    constexpr double kOfTwoEdges = 0.41;  // sqrt(2 / 12)
    constexpr int kParts = 4;
    const double periods = (stretch_.to_s - stretch_.from_s) / rhythm_.period_s;
    double most = 0.0;
    for (int parts = 1; parts <= kParts; ++parts) {
      const double step = parts * per_period_;
      // The line through whole samples' edges may itself be off by one.
      const double moved = std::max(0.0, periods * std::abs(step - std::round(step)) - 1.0);
      most = std::max(most, 1.0 / (1.0 + std::numbers::pi * moved) / parts);
    }
    return kOfTwoEdges * most / per_period_;
  }

  /// Share of samples between the levels.
  double share_between() const {
    constexpr double kNear = 0.2;  // of the jump
    double between = 0.0, all = 0.0;
    for (std::size_t i = first_; i < end_; ++i) {
      const PulseWindow* window = windows_.at(i);
      if (!window || !window->clear) continue;
      const double share = window->share(trace_.power_w[i]);
      between += share > kNear && share < 1.0 - kNear;
      all += 1.0;
    }
    return between / std::max(all, 1.0);
  }

  /// Whether some turns are all of the same brightest value, as of a converter at its end.
  bool clips() const {
    constexpr double kTurns = 3.0;
    float most_w = trace_.power_w[first_];
    double equal = 0.0;
    for (std::size_t i = first_; i < end_; ++i) {
      if (trace_.power_w[i] > most_w) equal = 0.0;
      most_w = std::max(most_w, trace_.power_w[i]);
      equal += trace_.power_w[i] == most_w;
    }
    return equal > kTurns * std::max(1.0, per_period_ * rhythm_.duty);
  }

  /// In the place of each sample the mean of both levels, weighed by their time, with what it has
  /// beside its level, of a fifth of a second, where that is `most_rest_w` at most: other light.
  /// `after` and `before` an edge, in periods, samples belong to neither; with `by_value` that goes
  /// for samples whose level is not told alone. False, and nothing done, where the levels are not
  /// steady.
  bool put_levels(double after, double before, bool by_value, double most_rest_w) {
    const auto turn_of = [&](std::size_t i, double phase) {
      const PulseWindow* window = windows_.at(i);
      if (by_value && window && window->told)
        return window->share(trace_.power_w[i]) > 0.5 ? Turn::on : Turn::off;
      if (phase > after && phase < rhythm_.duty - before) return Turn::on;
      return phase > rhythm_.duty + after && phase < 1.0 - before ? Turn::off : Turn::neither;
    };
    std::vector<Brightness> on = levels(Turn::on, turn_of);
    std::vector<Brightness> off = levels(Turn::off, turn_of);
    for (const auto* each : {&on, &off})
      if (!smooth(*each) || !flat(*each)) return false;
    if (most_rest_w > 0.0)
      for (auto* each : {&on, &off}) *each = calmed(*each);
    std::size_t next_on = 0, next_off = 0;
    for (std::size_t i = first_; i < end_; ++i) {
      const double time_s = trace_.time_s[i];
      const double on_w = at_time(on, next_on, time_s), off_w = at_time(off, next_off, time_s);
      double rest_w = 0.0;
      if (most_rest_w > 0.0) {
        const Turn turn = turn_of(i, PulseRhythm::phase_of(rhythm_.periods_at(time_s)));
        if (turn != Turn::neither) rest_w = trace_.power_w[i] - (turn == Turn::on ? on_w : off_w);
        if (std::abs(rest_w) > most_rest_w) rest_w = 0.0;
      }
      trace_.power_w[i] = static_cast<float>(std::lerp(off_w, on_w, rhythm_.duty) + rest_w);
    }
    return true;
  }

  /// In the place of each sample the mean over the period about it; samples fill their spacing.
  /// False, and nothing done, where those means are not steady.
  bool put_means() {
    std::vector<double> sums_w{0.0};
    for (std::size_t i = first_; i < end_; ++i) sums_w.push_back(sums_w.back() + trace_.power_w[i]);
    const auto sum_to = [&](double place) {
      const auto whole = std::min(static_cast<std::size_t>(place), sums_w.size() - 2);
      return std::lerp(sums_w[whole], sums_w[whole + 1], place - static_cast<double>(whole));
    };
    std::vector<float> means_w;
    std::vector<Brightness> each;
    for (std::size_t i = first_; i < end_; ++i) {
      const double middle = static_cast<double>(i - first_) + 0.5;
      const double from = middle - 0.5 * per_period_, to = middle + 0.5 * per_period_;
      const bool known = from >= 0.0 && to <= static_cast<double>(end_ - first_);
      means_w.push_back(known ? static_cast<float>((sum_to(to) - sum_to(from)) / per_period_)
                              : trace_.power_w[i]);
      if (known && (each.empty() || trace_.time_s[i] > each.back().time_s + rhythm_.period_s))
        each.push_back({trace_.time_s[i], means_w.back(), 0.0, static_cast<int>(per_period_)});
    }
    constexpr double kNear = 0.2;  // of the jump: at a level
    const Turn longer = rhythm_.duty > 0.5 ? Turn::on : Turn::off;
    const auto turn_of = [&](std::size_t i, double) {
      const PulseWindow* window = windows_.at(i);
      if (!window || !window->told) return Turn::neither;
      const double share = window->share(trace_.power_w[i]);
      return share < kNear ? Turn::off : share > 1.0 - kNear ? Turn::on : Turn::neither;
    };
    if (!smooth(each) || !flat(levels(longer, turn_of))) return false;
    std::ranges::copy(means_w, trace_.power_w.begin() + static_cast<std::ptrdiff_t>(first_));
    return true;
  }

 private:
  enum class Turn { on, off, neither };
  static constexpr std::size_t kFewestLevels = 8;

  /// Means of the samples of each such turn.
  std::vector<Brightness> levels(Turn turn, const auto& turn_of) const {
    std::vector<Brightness> levels;
    Brightness sum;
    double number = NAN, first_w = 0.0, last_w = 0.0;
    const auto close = [&] {
      if (sum.samples > 0)
        levels.push_back(
            {sum.time_s / sum.samples, sum.power_w / sum.samples, last_w - first_w, sum.samples});
      sum = {};
    };
    for (std::size_t i = first_; i < end_; ++i) {
      const double periods = rhythm_.periods_at(trace_.time_s[i]),
                   phase = PulseRhythm::phase_of(periods);
      if (turn_of(i, phase) != turn) continue;
      if (std::floor(periods) != number) close();
      number = std::floor(periods);
      last_w = trace_.power_w[i];
      if (sum.samples == 0) first_w = last_w;
      sum.time_s += trace_.time_s[i];
      sum.power_w += last_w;
      ++sum.samples;
    }
    close();
    return levels;
  }

  /// Means of levels over a tenth of a second to either side, or less by as many on both.
  std::vector<Brightness> averaged(std::vector<Brightness> levels) const {
    constexpr double kReach_s = 0.1;
    const auto reach = static_cast<std::size_t>(std::ceil(kReach_s / rhythm_.period_s));
    std::vector<double> sums_w{0.0};
    for (const Brightness& level : levels) sums_w.push_back(sums_w.back() + level.power_w);
    for (std::size_t k = 0; k < levels.size(); ++k) {
      const std::size_t beside = std::min({reach, k, levels.size() - 1 - k});
      levels[k].power_w =
          (sums_w[k + beside + 1] - sums_w[k - beside]) / static_cast<double>(2 * beside + 1);
    }
    return levels;
  }

  /// Levels without what goes to and fro in them within a fifth of a second: the means, and those
  /// of what the means have cut off a rise that bends.
  std::vector<Brightness> calmed(const std::vector<Brightness>& levels) const {
    std::vector<Brightness> calm = averaged(levels);
    const std::vector<Brightness> twice = averaged(calm);
    for (std::size_t k = 0; k < calm.size(); ++k)
      calm[k].power_w += calm[k].power_w - twice[k].power_w;
    return calm;
  }

  /// Calls `use(k, window)` for levels between two others where edges were seen.
  void where_clear(const std::vector<Brightness>& levels, const auto& use) const {
    for (std::size_t k = 1; k + 1 < levels.size(); ++k) {
      if (levels[k - 1].time_s < stretch_.from_s || levels[k + 1].time_s > stretch_.to_s) continue;
      const auto sample = static_cast<std::size_t>(
          std::ranges::lower_bound(trace_.time_s, levels[k].time_s) - trace_.time_s.begin());
      const PulseWindow* window = windows_.at(sample);
      if (window && window->clear) use(k, *window);
    }
  }

  /// Whether levels go on from one to the next as light of a vehicle does: no slow edges and no
  /// other light's pulses are in them.
  bool smooth(const std::vector<Brightness>& levels) const {
    constexpr double kUneven = 0.06, kSigmas = 3.0;          // of the jump
    constexpr double kSigmaFromMedian = 0.6744897501960817;  // median of |x|, x standard normal
    std::vector<double> bends, noises;
    where_clear(levels, [&](std::size_t k, const PulseWindow& window) {
      const Brightness &a = levels[k - 1], &b = levels[k], &c = levels[k + 1];
      const double share = (b.time_s - a.time_s) / (c.time_s - a.time_s);
      bends.push_back(std::abs(b.power_w - std::lerp(a.power_w, c.power_w, share)) /
                      window.jump_w());
      noises.push_back(trace_.noise_sigma_w / window.jump_w() / std::sqrt(b.samples));
    });
    return bends.size() >= kFewestLevels && median_of(bends) / (kSigmaFromMedian * std::sqrt(1.5)) <
                                                std::max(kUneven, kSigmas * median_of(noises));
  }

  /// Whether levels hold for a turn, as far as they are of several samples.
  bool flat(const std::vector<Brightness>& levels) const {
    constexpr double kRises = 0.04;  // of the jump
    std::vector<double> rises, noises;
    where_clear(levels, [&](std::size_t k, const PulseWindow& window) {
      if (levels[k].samples < 2) return;
      rises.push_back(levels[k].rise_w / window.jump_w());
      noises.push_back(trace_.noise_sigma_w / window.jump_w());
    });
    return rises.size() < kFewestLevels || std::abs(median_of(rises)) < kRises + median_of(noises);
  }

  PowerTrace& trace_;
  const PulseWindows& windows_;
  const PulseStretch& stretch_;
  PulseRhythm rhythm_;
  std::size_t first_, end_;
  double per_period_;
};

/// The samples whose light the stretch tells: beyond where its edges are seen by half of that time,
/// and 3 s at most, but not into others' pulses or over a gap.
Range reach_of(const PulseStretch& stretch, const PowerTrace& trace, const PulseWindows& windows,
               const Range& seen) {
  constexpr double kBeyond_s = 3.0, kBeyond = 0.5;
  constexpr double kMostGap = 1.5;  // periods of samples
  const double beyond_s = std::min(kBeyond_s, kBeyond * (stretch.to_s - stretch.from_s));
  const auto foreign = [&](std::size_t i) {
    const PulseWindow* window = windows.at(i);
    const std::size_t k = i / windows.samples;
    return window && window->clear && (k < seen.first || k >= seen.second);
  };
  const auto gap_before = [&](std::size_t i) {
    return trace.time_s[i] - trace.time_s[i - 1] > kMostGap * trace.sample_period_s;
  };
  Range reach{seen.first * windows.samples, seen.second * windows.samples};
  while (reach.first > 0 && !gap_before(reach.first) && !foreign(reach.first - 1) &&
         stretch.from_s - trace.time_s[reach.first - 1] < beyond_s)
    --reach.first;
  while (reach.second < trace.time_s.size() && !gap_before(reach.second) &&
         !foreign(reach.second) && trace.time_s[reach.second] - stretch.to_s < beyond_s)
    ++reach.second;
  return reach;
}

/// Evens out; gives the doubt about the duty, and nothing where the light cannot be told.
std::optional<double> put_mean_light(Turns& turns, double duty, double most_rest_w) {
  constexpr double kFewest = 0.95, kMany = 3.0;  // samples of a turn
  constexpr double kFewestOfPeriod = 3.0;
  constexpr double kOfEdges = 1.2;  // between the levels, of means
  constexpr double kInstants = 0.2, kFewMeans = 0.75, kMeans = 1.5, kSlow = 0.15;
  const double period = turns.samples_per_period(), turn = turns.samples_per_turn();
  if (period < kFewestOfPeriod || turn < kFewest || turns.clips()) return std::nullopt;
  const double between = turns.share_between() * period / kOfEdges;
  if (turn >= kMany) {
    // Once the lamps are on or off for a while, edges are over.
    constexpr double kAfter = 0.25, kBeforeSamples = 0.5;
    if (between > kMeans + kSlow * period / kOfEdges) return std::nullopt;
    const double after = std::max(kBeforeSamples / period, kAfter * std::min(duty, 1.0 - duty));
    if (!turns.put_levels(after, kBeforeSamples / period, false, most_rest_w)) return std::nullopt;
    return between > kInstants ? 0.0 : turns.duty_std();
  }
  constexpr double kMargin = 0.15;  // samples
  if (between < kInstants) {
    if (!turns.put_levels(kMargin / period, kMargin / period, true, most_rest_w))
      return std::nullopt;
    return turns.duty_std();
  }
  const bool means = between > kFewMeans && between < kMeans;
  return means && turns.put_means() ? std::optional(0.0) : std::nullopt;
}

/// What pulses on end: windows [begin, stop) of a trace.
class PulsingRun {
 public:
  PulsingRun(PowerTrace& trace, const PulseWindows& windows, Range run, double most_rest_w)
      : trace_(trace),
        windows_(windows),
        run_(run),
        most_rest_w_(most_rest_w),
        done_(run.second - run.first, 0) {}

  /// All of it, or nothing: a part that stays beside such that are evened out would no longer be
  /// told to pulse.
  void even_out() {
    constexpr double kMost_s = 4.0;                  // more than is reached beyond
    constexpr double kNearlyAll = 0.95, kDim = 0.3;  // what stays, of the brightest
    constexpr std::size_t kBeside = 8;
    const std::size_t begin = run_.first - std::min(run_.first, kBeside);
    const std::size_t end = std::min(windows_.each.size(), run_.second + kBeside);
    if (!std::all_of(at(begin), at(end), [](const PulseWindow& one) { return one.whole; })) return;
    const auto sample_at = [&](double time_s) {
      return std::ranges::lower_bound(trace_.time_s, time_s) - trace_.time_s.begin();
    };
    const auto first = sample_at(trace_.time_s[run_.first * windows_.samples] - kMost_s);
    const auto last = sample_at(trace_.time_s[run_.second * windows_.samples - 1] + kMost_s);
    const std::vector<float> before_w(trace_.power_w.begin() + first,
                                      trace_.power_w.begin() + last);
    const std::size_t found = trace_.pulsing.size();
    even_out_parts();
    const auto is_done = [&](std::size_t k) {
      return k >= run_.first && k < run_.second && done_[k - run_.first] != 0;
    };
    double clear = 0.0, done = 0.0, done_w = 0.0, left_w = 0.0;
    for (std::size_t k = run_.first; k < run_.second; ++k) {
      const PulseWindow& window = windows_.each[k];
      if (!window.clear) continue;
      clear += 1.0;
      done += is_done(k);
      if (is_done(k))
        done_w = std::max(done_w, window.jump_w());
      else if (!is_done(k + 1) && (k == 0 || !is_done(k - 1)))
        left_w = std::max(left_w, window.jump_w());
    }
    if (done >= kNearlyAll * clear && left_w < kDim * done_w) return;
    trace_.pulsing.resize(found);
    std::ranges::copy(before_w, trace_.power_w.begin() + first);
  }

 private:
  std::vector<PulseWindow>::const_iterator at(std::size_t window) const {
    return windows_.each.begin() + static_cast<std::ptrdiff_t>(window);
  }

  /// First what the brightest vehicle lights, then the rest; no more once too much cannot be told.
  void even_out_parts() {
    constexpr int kMostTries = 64;
    const PulseEdges edges = pulse_edges(trace_, windows_, run_.first, run_.second);
    std::vector<Range> left{run_};
    for (int tries = 0; !left.empty() && tries < kMostTries;) {
      const Range part = left.back();
      left.pop_back();
      if (part.second < part.first + kFewestWindows) continue;
      const auto brightest = std::max_element(
          at(part.first), at(part.second),
          [](const PulseWindow& a, const PulseWindow& b) { return a.jump_w() < b.jump_w(); });
      const auto middle = static_cast<std::size_t>(brightest - windows_.each.begin());
      const std::size_t found = trace_.pulsing.size();
      const Range seen = even_out_about(middle, part, edges);
      tries += trace_.pulsing.size() == found;
      left.emplace_back(part.first, seen.first);
      left.emplace_back(seen.second, part.second);
    }
  }

  /// Gives the windows that are done with.
  Range even_out_about(std::size_t middle, const Range& part, const PulseEdges& edges) {
    const std::size_t samples = windows_.samples;
    const auto within = [&](const std::vector<double>& all_s) {
      return std::span<const double>(
          std::ranges::lower_bound(all_s, trace_.time_s[part.first * samples]),
          std::ranges::upper_bound(all_s, trace_.time_s[part.second * samples - 1]));
    };
    const auto stretch =
        stretch_about(trace_.time_s[middle * samples + samples / 2], within(edges.up_s),
                      within(edges.down_s), trace_.sample_period_s);
    if (!stretch) return {middle, middle + 1};
    const auto window_at = [&](double time_s) {
      return static_cast<std::size_t>(std::ranges::lower_bound(trace_.time_s, time_s) -
                                      trace_.time_s.begin()) /
             samples;
    };
    const Range seen{std::max(part.first, window_at(stretch->from_s)),
                     std::min(part.second, window_at(stretch->to_s) + 1)};
    const Range reach = reach_of(*stretch, trace_, windows_, seen);
    Turns turns(trace_, windows_, *stretch, reach);
    if (const auto duty_std = put_mean_light(turns, stretch->rhythm.duty, most_rest_w_)) {
      trace_.pulsing.push_back({trace_.time_s[reach.first], trace_.time_s[reach.second - 1],
                                1.0 / stretch->rhythm.period_s, stretch->rhythm.duty, *duty_std});
      for (std::size_t k = seen.first; k < seen.second; ++k) done_[k - run_.first] = 1;
    }
    return seen;
  }

  PowerTrace& trace_;
  const PulseWindows& windows_;
  Range run_;
  double most_rest_w_;
  std::vector<char> done_;  // whether windows are evened out
};

double usual_jump_w(std::span<const PulseWindow> windows) {
  std::vector<double> jumps_w;
  for (const PulseWindow& window : windows)
    if (window.clear) jumps_w.push_back(window.jump_w());
  return median_of(jumps_w);
}

/// Windows in which lamps pulse on end.
std::vector<Range> runs_of(const std::vector<PulseWindow>& each) {
  constexpr std::size_t kMostBetween = 10;
  std::vector<Range> runs;
  for (std::size_t begin = 0, stop = 1; begin < each.size(); begin = stop) {
    stop = begin + 1;
    if (!each[begin].clear) continue;
    for (std::size_t i = stop; i < each.size() && i - stop < kMostBetween; ++i)
      if (each[i].clear) stop = i + 1;
    if (stop - begin >= kFewestWindows) runs.emplace_back(begin, stop);
  }
  return runs;
}

/// The trace without the flicker of other light, as that shows once the jumps of pulses alone are
/// taken out: levels told from samples with the flicker would hold its beat with the pulses.
/// Nothing where it cannot be told.
std::optional<PowerTrace> without_flicker(const PowerTrace& trace, const PulseWindows& windows,
                                          double waves_w, double mains_hz) {
  constexpr double kMostWaves = 0.25;  // of the jumps
  PowerTrace rest = trace;
  for (const Range& run : runs_of(windows.each)) {
    const auto of_run = std::span(windows.each).subspan(run.first, run.second - run.first);
    if (waves_w < kMostWaves * usual_jump_w(of_run))
      PulsingRun(rest, windows, run, waves_w).even_out();
  }
  if (rest.pulsing.empty()) return std::nullopt;
  PowerTrace found = trace;
  const std::vector<float> before_w = rest.power_w;
  remove_flicker(rest, mains_hz);
  if (rest.mains_hz == 0.0) return std::nullopt;
  found.mains_hz = rest.mains_hz;
  found.flicker_w = rest.flicker_w;
  remove_flicker(rest, mains_hz);  // what is left where pulses begin and end
  for (std::size_t i = 0; i < before_w.size(); ++i)
    found.power_w[i] -= before_w[i] - rest.power_w[i];
  return found;
}

}  // namespace

void even_out_pulses(PowerTrace& trace, double mains_hz) {
  if (trace.power_w.empty() || !(trace.sample_period_s > 0.0)) return;
  PulseWindows windows = pulse_windows(trace);
  if (runs_of(windows.each).empty()) return;
  if (const double waves_w = windows.waves_w(trace); waves_w > 0.0) {
    auto steady = without_flicker(trace, windows, waves_w, mains_hz);
    if (!steady) return;
    windows = pulse_windows(*steady);
    if (windows.waves_w(*steady) > 0.0) return;
    for (const Range& run : runs_of(windows.each))
      PulsingRun(*steady, windows, run, 0.0).even_out();
    if (steady->pulsing.empty()) return;
    trace = std::move(*steady);
  } else {
    for (const Range& run : runs_of(windows.each)) PulsingRun(trace, windows, run, 0.0).even_out();
  }
  std::ranges::sort(trace.pulsing, {}, &PulsingLight::from_s);
}

}  // namespace vildar
