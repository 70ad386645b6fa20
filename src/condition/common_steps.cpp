#include "condition/common_steps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "condition/sample_ranges.h"

namespace vildar {
namespace {

// The longer tells steps of a few percent of a vehicle's light; light on the way between two
// photodiodes takes 18 ms for a metre at 55 m/s.
constexpr std::array<double, 2> kBlocks_s{1e-3, 4e-3};
constexpr double kSigmas = 8.0;
constexpr std::int64_t kWindow = 4;                // blocks
constexpr std::int64_t kMargin = 3 * kWindow + 2;  // of blocks that it takes to tell a step
constexpr double kApart_m = 1.0;

/// Blocks that all traces share, of a sample at least.
struct Grid {
  double from_s = 0.0, step_s = 0.0;

  std::int64_t block_of(double time_s) const {
    constexpr double kEdge = 1e-6;
    return static_cast<std::int64_t>(std::floor((time_s - from_s) / step_s + kEdge));
  }
  double time_s(std::int64_t block) const { return from_s + static_cast<double>(block) * step_s; }
  std::int64_t blocks_in(double duration_s) const {
    return static_cast<std::int64_t>(std::round(duration_s / step_s));
  }
};

std::size_t sample_from(const PowerTrace& trace, double time_s) {
  return static_cast<std::size_t>(std::ranges::lower_bound(trace.time_s, time_s) -
                                  trace.time_s.begin());
}

/// A stretch of one trace: means of its blocks, NaN where a block has no sample.
class Steps {
 public:
  Steps(const PowerTrace& trace, const Grid& grid, std::int64_t first, std::int64_t blocks)
      : first_(first) {
    const auto size = static_cast<std::size_t>(blocks);
    std::vector<int> samples(size, 0);
    mean_w_.assign(size, 0.0);
    for (std::size_t i = sample_from(trace, grid.time_s(first)); i < trace.time_s.size(); ++i) {
      const std::int64_t block = grid.block_of(trace.time_s[i]) - first;
      if (block >= blocks) break;
      if (block < 0) continue;
      mean_w_[static_cast<std::size_t>(block)] += trace.power_w[i];
      ++samples[static_cast<std::size_t>(block)];
    }
    for (std::size_t i = 0; i < size; ++i)
      mean_w_[i] = samples[i] > 0 ? mean_w_[i] / samples[i] : std::nan("");
    const double in_block = std::max(1.0, grid.step_s / trace.sample_period_s);
    const double sigma_w =
        std::hypot(trace.noise_sigma_w / std::sqrt(in_block), trace.rounding_sigma_w);
    // Two means, and half of two of either side.
    least_w_ = kSigmas * sigma_w * std::sqrt(3.0 / static_cast<double>(kWindow));
  }

  double least_w() const { return least_w_; }

  /// Whether light might jump in that block; NaN says no.
  bool may_jump(std::int64_t block) const {
    return std::abs(mean_w(block + 1) - mean_w(block - 1)) > 0.5 * least_w_;
  }
  /// By how much it jumps, beyond what it changes by before and after; 0 where that is in the
  /// noise, not within the block, or beside a gap.
  double step_w(std::int64_t block) const {
    constexpr double kWithinBlock = 0.6;
    const std::int64_t aside = 2 * kWindow + 1;
    const double usual_w = 0.5 * (change_w(block - aside) + change_w(block + aside));
    const double step_w = change_w(block) - usual_w;
    if (!(std::abs(step_w) > least_w_)) return 0.0;
    const double usual_across_w = 2.0 * usual_w / static_cast<double>(kWindow + 1);
    const double across_w = mean_w(block + 1) - mean_w(block - 1) - usual_across_w;
    return across_w / step_w > kWithinBlock ? step_w : 0.0;
  }

 private:
  double mean_w(std::int64_t block) const {
    return mean_w_[static_cast<std::size_t>(block - first_)];
  }
  double change_w(std::int64_t block) const {
    double before_w = 0.0, after_w = 0.0;
    for (std::int64_t i = 1; i <= kWindow; ++i) {
      before_w += mean_w(block - i);
      after_w += mean_w(block + i);
    }
    return (after_w - before_w) / static_cast<double>(kWindow);
  }

  std::int64_t first_;
  std::vector<double> mean_w_;
  double least_w_ = 0.0;
};

/// In one block; heights by trace, 0 in those that do not show it, and the least that they show.
struct CommonStep {
  std::int64_t block = 0;
  std::vector<double> height_w, least_w;
  double worth = 0.0;  ///< in least heights, of all traces
};

CommonStep step_in(const std::vector<Steps>& traces, const std::vector<Metres>& along,
                   std::int64_t block) {
  CommonStep step;
  step.block = block;
  for (const Steps& trace : traces) {
    step.height_w.push_back(trace.step_w(block));
    step.least_w.push_back(trace.least_w());
  }
  for (std::size_t i = 0; i < traces.size(); ++i) {
    const bool shared = std::ranges::any_of(along, [&](const Metres& other) {
      const auto k = static_cast<std::size_t>(&other - along.data());
      return std::abs(other.value() - along[i].value()) >= kApart_m &&
             step.height_w[k] * step.height_w[i] != 0.0;
    });
    if (shared) step.worth += std::abs(step.height_w[i]) / traces[i].least_w();
  }
  return step;
}

/// Those of a stretch, after what was found before it.
void add_common_steps(const std::vector<Steps>& stretch, const std::vector<Metres>& along,
                      std::int64_t first, std::int64_t blocks, std::vector<CommonStep>& steps) {
  for (std::int64_t block = first + kMargin; block + kMargin < first + blocks; ++block) {
    const auto jumping =
        std::ranges::count_if(stretch, [&](const Steps& one) { return one.may_jump(block); });
    if (jumping < 2) continue;
    CommonStep step = step_in(stretch, along, block);
    if (!(step.worth > 0.0)) continue;
    if (steps.empty() || block - steps.back().block > kWindow)
      steps.push_back(std::move(step));
    else if (step.worth > steps.back().worth)
      steps.back() = std::move(step);
  }
}

/// Stretch by stretch, so that long records take no more room than short ones.
std::vector<CommonStep> common_steps(const std::vector<PowerTrace>& traces,
                                     const std::vector<Metres>& along, const Grid& grid) {
  constexpr std::int64_t kStretch = 1 << 16;
  double to_s = grid.from_s;
  for (const PowerTrace& trace : traces) to_s = std::max(to_s, trace.time_s.back());
  std::vector<CommonStep> steps;
  for (std::int64_t first = 0, last = grid.block_of(to_s); first <= last;) {
    std::vector<Steps> stretch;
    for (const PowerTrace& trace : traces) stretch.emplace_back(trace, grid, first, kStretch);
    add_common_steps(stretch, along, first, kStretch, steps);
    first += kStretch - 2 * kMargin;
    double next_s = to_s;
    for (const PowerTrace& trace : traces)
      if (const std::size_t i = sample_from(trace, grid.time_s(first)); i < trace.time_s.size())
        next_s = std::min(next_s, trace.time_s[i]);
    first = std::max(first, grid.block_of(next_s));
    if (!(next_s < to_s)) break;
  }
  return steps;
}

/// Leaves out those that follow one another as pulses do.
void leave_pulses(std::vector<CommonStep>& steps, const Grid& grid) {
  constexpr double kWithin_s = 1.0;
  constexpr std::size_t kMost = 10;
  const std::int64_t within = grid.blocks_in(kWithin_s);
  std::vector<char> pulses(steps.size(), 0);
  for (std::size_t first = 0, last = 0; last < steps.size(); ++last) {
    while (steps[last].block - steps[first].block > within) ++first;
    if (last - first + 1 > kMost)
      std::fill(pulses.begin() + static_cast<std::ptrdiff_t>(first),
                pulses.begin() + static_cast<std::ptrdiff_t>(last) + 1, char{1});
  }
  std::vector<CommonStep> kept;
  for (std::size_t i = 0; i < steps.size(); ++i)
    if (!pulses[i]) kept.push_back(std::move(steps[i]));
  steps = std::move(kept);
}

// What shines for a while from elsewhere is as bright at its end, where a vehicle's own light has
// changed; what was dark for a while may have.
bool undoes(const CommonStep& later, const CommonStep& earlier) {
  constexpr double kSame = 0.05, kAlike = 1.0 / 3.0, kNoise = 0.5;
  bool any = false;
  for (std::size_t i = 0; i < later.height_w.size(); ++i) {
    const double one_w = later.height_w[i], other_w = earlier.height_w[i];
    if (one_w == 0.0 && other_w == 0.0) continue;
    if (!(one_w * other_w < 0.0)) return false;
    const double most_w = std::max(std::abs(one_w), std::abs(other_w));
    const double off_w = (other_w > 0.0 ? kSame : kAlike) * most_w + kNoise * later.least_w[i];
    if (std::abs(one_w + other_w) > off_w) return false;
    any = true;
  }
  return any;
}

/// What lasted from one step to the one that undid it.
struct Switched {
  const CommonStep *from, *to;
};

std::vector<Switched> pairs_of(const std::vector<CommonStep>& steps, const Grid& grid) {
  constexpr double kLongest_s = 60.0;
  const std::int64_t longest = grid.blocks_in(kLongest_s);
  std::vector<Switched> pairs;
  std::vector<const CommonStep*> open;
  for (const CommonStep& step : steps) {
    std::erase_if(open, [&](const CommonStep* one) { return step.block - one->block > longest; });
    const auto undone = std::find_if(open.rbegin(), open.rend(),
                                     [&](const CommonStep* one) { return undoes(step, *one); });
    if (undone == open.rend()) {
      open.push_back(&step);
      continue;
    }
    pairs.push_back({*undone, &step});
    open.erase(std::next(undone).base());
  }
  return pairs;
}

void take_out(PowerTrace& trace, std::size_t index, const std::vector<Switched>& pairs,
              const Grid& grid) {
  std::vector<std::int64_t> jumps;
  for (const auto& [from, to] : pairs) {
    const double first_w = from->height_w[index], last_w = -to->height_w[index];
    if (first_w == 0.0 || last_w == 0.0) continue;
    trace.switched_w = std::max({trace.switched_w, std::abs(first_w), std::abs(last_w)});
    const double from_s = grid.time_s(from->block), to_s = grid.time_s(to->block);
    const std::size_t end = sample_from(trace, to_s);
    for (std::size_t i = sample_from(trace, from_s); i < end; ++i) {
      const double share = (trace.time_s[i] - from_s) / (to_s - from_s);
      trace.power_w[i] -= static_cast<float>(first_w + share * (last_w - first_w));
    }
    jumps.insert(jumps.end(), {from->block, to->block});
  }
  std::ranges::sort(jumps);
  std::vector<SampleRange> ranges;
  for (const std::int64_t block : jumps) {
    const std::size_t first = sample_from(trace, grid.time_s(block)),
                      end = sample_from(trace, grid.time_s(block + 1));
    if (end > first) ranges.push_back({first, end - first});
  }
  if (const std::int64_t dropped = drop_ranges(trace, ranges); dropped > 0)
    trace.rejected["switching"] += dropped;
}

}  // namespace

void remove_common_steps(std::vector<PowerTrace>& traces, const std::vector<Metres>& along) {
  const bool usable = std::ranges::all_of(traces, [](const PowerTrace& trace) {
    return trace.time_s.size() > 1 && trace.noise_sigma_w > 0.0 && trace.sample_period_s > 0.0;
  });
  if (traces.size() < 2 || !usable) return;
  for (const double block_s : kBlocks_s) {
    Grid grid{std::numeric_limits<double>::infinity(), block_s};
    for (const PowerTrace& trace : traces) {
      grid.from_s = std::min(grid.from_s, trace.time_s.front());
      grid.step_s = std::max(grid.step_s, trace.sample_period_s);
    }
    if (grid.step_s > kBlocks_s.back()) return;  // light is on its way for as long
    grid.from_s -= 0.5 * grid.step_s;
    std::vector<CommonStep> steps = common_steps(traces, along, grid);
    leave_pulses(steps, grid);
    const std::vector<Switched> pairs = pairs_of(steps, grid);
    for (std::size_t i = 0; i < traces.size(); ++i) take_out(traces[i], i, pairs, grid);
  }
}

}  // namespace vildar
