#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "condition/condition.h"

namespace vildar {
namespace {

constexpr double kGapPeriods = 2.5;
constexpr double kEdge =
    1e-6;  // of a block: stamps on an edge open the next block despite rounding

/// Samples [first, last) of a trace.
struct Run {
  std::size_t first = 0;
  std::size_t last = 0;
  std::size_t size() const { return last - first; }
};

Run longest_unbroken(const PowerTrace& trace, Run block) {
  Run longest{block.first, block.first};
  Run current = longest;
  for (std::size_t i = block.first; i < block.last; ++i) {
    if (i > current.first &&
        trace.time_s[i] - trace.time_s[i - 1] > kGapPeriods * trace.sample_period_s)
      current.first = i;
    current.last = i + 1;
    if (current.size() > longest.size()) longest = current;
  }
  return longest;
}

PowerBlock mean_of(const PowerTrace& trace, Run run) {
  const double start_s = trace.time_s[run.first];
  double sum_w = 0.0;
  double sum_s = 0.0;
  for (std::size_t i = run.first; i < run.last; ++i) {
    sum_w += trace.power_w[i];
    sum_s += trace.time_s[i] - start_s;
  }
  const auto n = static_cast<double>(run.size());
  PowerBlock block;
  block.time_s = start_s + sum_s / n;
  block.duration_s = n * trace.sample_period_s;
  block.power_w = sum_w / n;
  block.sigma_w = trace.noise_sigma_w / std::sqrt(n);
  block.samples = static_cast<int>(run.size());
  return block;
}

}  // namespace

std::vector<PowerBlock> block_means(const PowerTrace& trace, double from_s, double to_s,
                                    double block_s) {
  if (!(block_s > 0.0) || !(from_s <= to_s) || !std::isfinite(from_s) || !std::isfinite(to_s) ||
      !std::isfinite(block_s))
    throw std::invalid_argument(
        "block_means: block_s must be positive, from_s <= to_s, all finite");
  std::vector<PowerBlock> blocks;
  const auto begin = trace.time_s.begin();
  auto at = std::lower_bound(begin, trace.time_s.end(), from_s);
  const double half_full = 0.5 * block_s / std::max(trace.sample_period_s, 1e-12);
  while (at != trace.time_s.end() && *at < to_s) {
    // Counted from from_s, not added up, so that long traces do not drift; gaps are skipped at
    // once.
    const double index = std::floor((*at - from_s) / block_s + kEdge);
    const double block_end_s = std::min(from_s + (index + 1.0 - kEdge) * block_s, to_s);
    auto end = std::lower_bound(at, trace.time_s.end(), block_end_s);
    if (end == at) ++end;
    const Run run = longest_unbroken(
        trace, {static_cast<std::size_t>(at - begin), static_cast<std::size_t>(end - begin)});
    if (static_cast<double>(run.size()) >= half_full) blocks.push_back(mean_of(trace, run));
    at = end;
  }
  return blocks;
}

}  // namespace vildar
