#include "condition/clean_samples.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <utility>

#include <Eigen/Core>

#include "condition/stuck_samples.h"

namespace vildar {
namespace {

constexpr std::size_t kFlatRun = 5;
constexpr float kRailFraction = 0.999F;  // the top code of a converter of 10 bits or more

struct Rails {
  float low = -std::numeric_limits<float>::infinity();
  float high = std::numeric_limits<float>::infinity();
  bool known = false;
};

bool is_top_code(float value) {
  for (int bits = 7; bits <= 24; ++bits)
    if (value == static_cast<float>((1 << bits) - 1)) return true;
  return false;
}

Rails rails_of_counts(const std::vector<float>& values) {
  Rails rails;
  const auto [lowest, highest] = std::minmax_element(values.begin(), values.end());
  if (!std::all_of(values.begin(), values.end(),
                   [](float value) { return value == std::floor(value); }))
    return rails;
  if (*highest < 127.0F)
    return rails;  // 0 is the bottom of a converter only where the codes are those of one
  if (*lowest == 0.0F) rails.low = 0.0F;
  if (*lowest < 0.0F && is_top_code(-*lowest - 1.0F)) rails.low = *lowest;
  if (is_top_code(*highest)) {
    rails.high = *highest;
    rails.known = true;
  }
  return rails;
}

Rails rails_of(const std::vector<float>& values, PowerQuantity quantity,
               const PhotodiodeSite& photodiode) {
  if (quantity == PowerQuantity::counts && !photodiode.full_scale_v) return rails_of_counts(values);
  if (!photodiode.full_scale_v) return {};
  double full_scale = *photodiode.full_scale_v;
  if (quantity == PowerQuantity::counts)
    full_scale = photodiode.volts_per_count ? full_scale / *photodiode.volts_per_count : 1.0;
  else if (quantity != PowerQuantity::voltage_v)
    return {};
  const float rail = kRailFraction * static_cast<float>(full_scale);
  return {.low = -rail, .high = rail, .known = true};
}

/// Whether `holds(first, last)` for all of [0, count), a stretch at a time: within one there is no
/// branch, so that the compiler makes vectors of it.
template <class Holds>
bool holds_throughout(std::size_t count, Holds holds) {
  constexpr std::size_t kStretch = 1024;
  for (std::size_t first = 0; first < count; first += kStretch)
    if (!holds(first, std::min(first + kStretch, count))) return false;
  return true;
}

/// Share of the samples between the ends that equal their neighbour: how much the converter hides.
double share_of_equals(const std::vector<float>& values, float lowest, float highest) {
  std::int64_t equal = 0, all = 0;
  holds_throughout(values.size() - 1, [&](std::size_t first, std::size_t last) {
    std::int32_t equal_here = 0, all_here = 0;
    for (std::size_t i = first; i < last; ++i) {
      const std::int32_t inner = (values[i + 1] != lowest) & (values[i + 1] != highest);
      equal_here += inner & (values[i + 1] == values[i]);
      all_here += inner;
    }
    equal += equal_here;
    all += all_here;
    return true;
  });
  return all > 0 ? static_cast<double>(equal) / static_cast<double>(all) : 1.0;
}

/// Runs of at least `least` samples for which `is_at_end` holds. Such a run cannot miss every
/// `least`-th sample, so only those are looked at.
template <class AtEnd>
void add_runs(const std::vector<float>& values, std::size_t least, AtEnd is_at_end,
              std::vector<Span>& runs) {
  std::size_t after_last = 0;
  for (std::size_t i = least - 1; i < values.size(); i += least) {
    if (!is_at_end(values[i])) continue;
    std::size_t first = i, end = i + 1;
    while (first > after_last && is_at_end(values[first - 1])) --first;
    while (end < values.size() && is_at_end(values[end])) ++end;
    if (end - first >= least) runs.push_back({first, end});
    after_last = end;
    i = end - 1;
  }
}

/// Whether the samples beyond the ends of `runs` go to and fro by noise, white or as slow as 10 Hz,
/// as they do where a converter's end cuts a trace; the light next to what is dark in a trace
/// without noise rises or falls.
bool noisy_beyond(const std::vector<float>& values, double period_s,
                  const std::vector<Span>& runs) {
  constexpr std::size_t kFewest = 12, kOneIn = 4;
  constexpr double kBeyond_s = 0.2;
  constexpr int kTurns = 2;  // light that peaks there turns once
  const auto beyond =
      std::max(kFewest, static_cast<std::size_t>(std::ceil(std::min(kBeyond_s / period_s, 1e6))));
  std::size_t ends = 0, noisy = 0;
  const auto look = [&](std::size_t first, std::size_t last) {
    if (last - first < kFewest) return;
    int turns = 0;
    bool rises = false, falls = false;
    for (std::size_t i = first; i + 1 < last && turns < kTurns; ++i) {
      const bool up = values[i + 1] > values[i], down = values[i + 1] < values[i];
      turns += (up && falls) || (down && rises) ? 1 : 0;
      rises = up || (rises && !down);
      falls = down || (falls && !up);
    }
    ++ends;
    noisy += turns >= kTurns ? 1 : 0;
  };
  for (const Span& run : runs) {
    look(run.first - std::min(beyond, run.first), run.first);
    look(run.last, std::min(run.last + beyond, values.size()));
  }
  return ends > 0 && ends <= kOneIn * noisy;
}

/// Runs of clipped samples, in order.
std::vector<Span> clipped(const std::vector<float>& values, double period_s, const Rails& rails) {
  std::vector<Span> runs;
  const Eigen::Map<const Eigen::ArrayXf> array(values.data(),
                                               static_cast<Eigen::Index>(values.size()));
  const float low = array.minCoeff(), high = array.maxCoeff();
  if (low <= rails.low || high >= rails.high)
    add_runs(
        values, 1, [&](float value) { return value <= rails.low || value >= rails.high; }, runs);
  if (rails.known || low == high) return runs;
  // As many equal samples in a row as chance gives in one trace of a thousand.
  constexpr double kLeastShare = 0.01, kMostShare = 0.97, kChance = 1e-3;
  const double equals = share_of_equals(values, low, high);
  const double chance = std::log(kChance / static_cast<double>(values.size())) /
                        std::log(std::clamp(equals, kLeastShare, kMostShare));
  const std::size_t least = std::max(kFlatRun, 1 + static_cast<std::size_t>(std::ceil(chance)));
  // A converter coarser than the noise shows the dark as one flat line.
  constexpr double kFine = 0.5;
  add_runs(
      values, least, [high](float value) { return value == high; }, runs);
  if (equals < kFine && low > rails.low) {
    std::vector<Span> lowest;
    add_runs(
        values, least, [low](float value) { return value == low; }, lowest);
    if (noisy_beyond(values, period_s, lowest))
      runs.insert(runs.end(), lowest.begin(), lowest.end());
  }
  std::sort(runs.begin(), runs.end(),
            [](const Span& one, const Span& other) { return one.first < other.first; });
  return runs;
}

/// Indices of the longest strictly increasing selection of `time_s` (patience sorting): one wild
/// stamp costs itself, and not all that come after it.
std::vector<std::size_t> increasing_selection(const std::vector<double>& time_s) {
  constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  std::vector<std::size_t> tails;  // tails[k]: last sample of the best selection of k + 1 samples
  std::vector<std::size_t> before(time_s.size(), kNone);
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    auto place = tails.end();
    if (!tails.empty() && !(time_s[i] > time_s[tails.back()]))
      place = std::lower_bound(
          tails.begin(), tails.end(), time_s[i],
          [&](std::size_t tail, double stamp_s) { return time_s[tail] < stamp_s; });
    if (place != tails.begin()) before[i] = *(place - 1);
    if (place == tails.end()) tails.push_back(i);
    // Of equal stamps the first stays.
    else if (time_s[*place] != time_s[i])
      *place = i;
  }
  std::vector<std::size_t> selected(tails.size());
  std::size_t at = tails.empty() ? kNone : tails.back();
  for (std::size_t k = tails.size(); k-- > 0; at = before[at]) selected[k] = at;
  return selected;
}

void keep_finite(CleanSamples& clean) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < clean.values.size(); ++i) {
    const bool finite = std::isfinite(clean.values[i]) && std::isfinite(clean.time_s[i]);
    clean.time_s[count] = clean.time_s[i];
    clean.values[count] = clean.values[i];
    count += finite ? 1 : 0;
  }
  clean.rejected["not_a_number"] = static_cast<std::int64_t>(clean.values.size() - count);
  clean.time_s.resize(count);
  clean.values.resize(count);
}

void reject(CleanSamples& clean, const std::string& reason) { ++clean.rejected[reason]; }

/// Keeps the longest increasing selection; the rest is counted.
void put_in_order(CleanSamples& clean) {
  const auto& time_s = clean.time_s;
  const bool increasing =
      time_s.empty() ||
      holds_throughout(time_s.size() - 1, [&](std::size_t first, std::size_t last) {
        int falls = 0;
        for (std::size_t i = first; i < last; ++i) falls |= !(time_s[i] < time_s[i + 1]);
        return falls == 0;
      });
  if (increasing) return;
  if (const auto falls = std::ranges::adjacent_find(time_s, std::ranges::greater());
      falls != time_s.end())
    clean.fall = StampFall{falls[0], falls[1]};
  const std::vector<std::size_t> selected = increasing_selection(time_s);
  std::vector<double> kept_s;
  std::vector<float> kept;
  kept_s.reserve(selected.size());
  kept.reserve(selected.size());
  for (const std::size_t i : selected) {
    kept_s.push_back(time_s[i]);
    kept.push_back(clean.values[i]);
  }
  std::size_t next = 0;
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    if (next < selected.size() && selected[next] == i) {
      ++next;
      continue;
    }
    const bool repeats = std::binary_search(kept_s.begin(), kept_s.end(), time_s[i]);
    reject(clean, repeats ? "repeated" : "out_of_order");
  }
  clean.time_s = std::move(kept_s);
  clean.values = std::move(kept);
}

/// When `runs` are, those less than 0.05 s apart as one.
std::vector<ClippedTime> times_of(const std::vector<Span>& runs,
                                  const std::vector<double>& time_s) {
  constexpr double kApart_s = 0.05;
  std::vector<ClippedTime> times;
  for (const Span& run : runs) {
    const double from_s = time_s[run.first], to_s = time_s[run.last - 1];
    if (times.empty() || from_s - times.back().to_s > kApart_s)
      times.push_back({from_s, to_s});
    else
      times.back().to_s = to_s;
  }
  return times;
}

/// `runs` in order; `reason_of` the value that one begins with.
void leave_out(const std::vector<Span>& runs, const auto& reason_of, CleanSamples& clean) {
  if (runs.empty()) return;
  std::size_t kept = runs.front().first;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    clean.rejected[reason_of(clean.values[runs[r].first])] +=
        static_cast<std::int64_t>(runs[r].last - runs[r].first);
    const std::size_t end = r + 1 < runs.size() ? runs[r + 1].first : clean.values.size();
    for (std::size_t i = runs[r].last; i < end; ++i, ++kept) {
      clean.time_s[kept] = clean.time_s[i];
      clean.values[kept] = clean.values[i];
    }
  }
  clean.time_s.resize(kept);
  clean.values.resize(kept);
}

}  // namespace

CleanSamples clean_samples(std::vector<double> time_s, std::vector<float> values,
                           PowerQuantity quantity, const PhotodiodeSite& photodiode) {
  time_s.resize(values.size());
  const bool all_finite = holds_throughout(values.size(), [&](std::size_t first, std::size_t last) {
    constexpr float kMost = std::numeric_limits<float>::max();
    constexpr double kMost_s = std::numeric_limits<double>::max();
    int strange = 0;
    for (std::size_t i = first; i < last; ++i) strange |= !(std::abs(values[i]) <= kMost);
    for (std::size_t i = first; i < last; ++i) strange |= !(std::abs(time_s[i]) <= kMost_s);
    return strange == 0;
  });
  CleanSamples finite{std::move(time_s), std::move(values), {}, {}, {}};
  if (!all_finite) keep_finite(finite);
  put_in_order(finite);
  if (finite.values.empty()) return finite;

  const double period_s =
      (finite.time_s.back() - finite.time_s.front()) / static_cast<double>(finite.time_s.size());
  const std::vector<Span> ends =
      clipped(finite.values, period_s, rails_of(finite.values, quantity, photodiode));
  const float lowest = ends.empty() ? 0.0F : *std::ranges::min_element(finite.values);
  const bool unplugged = !ends.empty() && stands_apart(finite.values, lowest);
  const auto lost = [&](float held) { return unplugged && held == lowest; };
  std::vector<Span> cut;
  std::ranges::copy_if(ends, std::back_inserter(cut),
                       [&](const Span& run) { return !lost(finite.values[run.first]); });
  finite.clipped = times_of(cut, finite.time_s);
  leave_out(
      ends, [&](float held) { return lost(held) ? "stuck" : "clipped"; }, finite);
  leave_out(
      stuck_runs(finite.time_s, finite.values), [](float) { return "stuck"; }, finite);
  return finite;
}

}  // namespace vildar
