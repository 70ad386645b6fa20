#include "condition/stuck_samples.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace vildar {
namespace {

constexpr double kLeast_s = 0.05;
constexpr double kChance = 1e-9;
constexpr std::size_t kEvidence = 100;  // samples: tell a share of 0.4 from 0.6
// Noise below one step makes half of the neighbours equal, or more; noise of 0.7 steps makes 0.4.
constexpr double kLeastShare = 0.01, kMostShare = 0.4;

/// Samples in a row that chance makes equal in fewer than kChance traces. The likeliest code comes
/// with at most the root of the chance that two samples share one.
std::size_t least_samples(std::size_t count, double share) {
  const double log_chance = std::log(kChance / static_cast<double>(count));
  const double log_code = 0.5 * std::log(std::max(share, kLeastShare));
  return 1 + static_cast<std::size_t>(std::ceil(log_chance / log_code));
}

/// A run of equal samples that stands between samples that differ.
struct Candidate {
  Span run;
  double share = 0.0;  ///< of equal neighbours about it
};

/// Share of samples in [first, last) that equal the next one, or the one after that if those are
/// more: mains flicker of half the sample rate parts neighbours without any noise.
double share_of_equals(const std::vector<float>& values, std::size_t first, std::size_t last) {
  std::size_t equal_next = 0, equal_second = 0;
  for (std::size_t i = first; i + 2 < last; ++i) {
    equal_next += values[i] == values[i + 1] ? 1 : 0;
    equal_second += values[i] == values[i + 2] ? 1 : 0;
  }
  return static_cast<double>(std::max(equal_next, equal_second)) /
         static_cast<double>(last - first - 2);
}

/// The greater of the shares before and after a run; nothing where the trace has too little there.
std::optional<double> share_about(const std::vector<float>& values, Span run) {
  constexpr std::size_t kFewest = 12;
  std::optional<double> share;
  if (run.first >= kFewest)
    share = share_of_equals(values, run.first - std::min(run.first, kEvidence), run.first);
  if (const std::size_t left = values.size() - run.last; left >= kFewest)
    share = std::max(share.value_or(0.0),
                     share_of_equals(values, run.last, run.last + std::min(left, kEvidence)));
  return share;
}

std::vector<Candidate> candidates(const std::vector<double>& time_s,
                                  const std::vector<float>& values) {
  std::vector<Candidate> found;
  // Of a run of `step` + 1 samples every `step`-th one and the next are looked at.
  const std::size_t step = least_samples(values.size(), 0.0) - 1;
  for (std::size_t i = 0; i + 1 < values.size(); i += step) {
    if (values[i] != values[i + 1]) continue;
    Span run{i, i + 2};
    while (run.first > 0 && values[run.first - 1] == values[i]) --run.first;
    while (run.last < values.size() && values[run.last] == values[i]) ++run.last;
    i = run.last - 1;
    if (run.last - run.first <= step || time_s[run.last - 1] - time_s[run.first] < kLeast_s)
      continue;
    if (const std::optional<double> share = share_about(values, run); share && *share <= kMostShare)
      found.push_back({run, *share});
  }
  return found;
}

/// Neighbours: all of them, and those that are equal.
struct Neighbours {
  std::size_t all = 0, equal = 0;
};

/// For each of `levels` (increasing) the samples that are no brighter, each with the next one.
std::vector<Neighbours> no_brighter(const std::vector<float>& values,
                                    const std::vector<float>& levels) {
  std::vector<Neighbours> found(levels.size());
  for (std::size_t i = 0; i + 1 < values.size(); ++i) {
    const auto level = std::lower_bound(levels.begin(), levels.end(), values[i]);
    if (level == levels.end()) continue;
    Neighbours& here = found[static_cast<std::size_t>(level - levels.begin())];
    ++here.all;
    here.equal += values[i] == values[i + 1] ? 1 : 0;
  }
  for (std::size_t k = 1; k < found.size(); ++k) {
    found[k].all += found[k - 1].all;
    found[k].equal += found[k - 1].equal;
  }
  return found;
}

}  // namespace

std::vector<Span> stuck_runs(const std::vector<double>& time_s, const std::vector<float>& values) {
  std::vector<Span> runs;
  if (values.empty()) return runs;
  const std::vector<Candidate> all = candidates(time_s, values);
  if (all.empty()) return runs;
  std::vector<float> levels;
  for (const Candidate& candidate : all) levels.push_back(values[candidate.run.first]);
  std::sort(levels.begin(), levels.end());
  levels.erase(std::unique(levels.begin(), levels.end()), levels.end());
  const std::vector<Neighbours> darker = no_brighter(values, levels);
  const bool apart =
      levels.front() == *std::ranges::min_element(values) && stands_apart(values, levels.front());
  for (const auto& [run, share_about] : all) {
    const auto level = std::lower_bound(levels.begin(), levels.end(), values[run.first]);
    auto [others, equal] = darker[static_cast<std::size_t>(level - levels.begin())];
    const std::size_t length = run.last - run.first;
    others -= length - (run.last == values.size() ? 1 : 0);
    equal -= length - 1;
    const bool unplugged = apart && level == levels.begin();
    if (others < kEvidence && !unplugged) continue;
    const double share =
        unplugged ? share_about
                  : std::max(share_about, static_cast<double>(equal) / static_cast<double>(others));
    if (share <= kMostShare && length >= least_samples(values.size(), share)) runs.push_back(run);
  }
  return runs;
}

bool stands_apart(const std::vector<float>& values, float lowest) {
  constexpr float kApart = 10.0F;  // medians of the steps between neighbours
  constexpr double kTurns = 0.05;  // of the steps; of light without noise very few turn
  std::vector<float> steps;
  float next = std::numeric_limits<float>::max();
  double turns = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i] == lowest) continue;
    next = std::min(next, values[i]);
    if (i == 0 || values[i - 1] == lowest) continue;
    steps.push_back(std::abs(values[i] - values[i - 1]));
    if (i + 1 < values.size() && values[i + 1] != lowest)
      turns += (values[i] > values[i - 1]) != (values[i + 1] > values[i]) ? 1.0 : 0.0;
  }
  if (steps.size() < kEvidence || turns < kTurns * static_cast<double>(steps.size())) return false;
  const auto middle = steps.begin() + std::ssize(steps) / 2;
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle > 0.0F && next - lowest > kApart * *middle;
}

}  // namespace vildar
