#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "condition/condition.h"
#include "condition/stamps.h"

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
  const double span_s = trace.time_s[block.last - 1] - trace.time_s[block.first];
  if (span_s < (static_cast<double>(block.size()) - 2.0 + kGapPeriods) * trace.sample_period_s)
    return block;  // too short for all its samples and a gap
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
  // Four sums of each, so that no addition has to wait for the one before it.
  std::array<double, 4> sums_w{}, sums_s{};
  std::size_t i = run.first;
  for (; i + 4 <= run.last; i += 4)
    for (std::size_t lane = 0; lane < 4; ++lane) {
      sums_w[lane] += trace.power_w[i + lane];
      sums_s[lane] += trace.time_s[i + lane] - start_s;
    }
  for (; i < run.last; ++i) {
    sums_w[0] += trace.power_w[i];
    sums_s[0] += trace.time_s[i] - start_s;
  }
  const double sum_w = sums_w[0] + sums_w[1] + sums_w[2] + sums_w[3];
  const double sum_s = sums_s[0] + sums_s[1] + sums_s[2] + sums_s[3];
  const auto n = static_cast<double>(run.size());
  PowerBlock block;
  block.time_s = start_s + sum_s / n;
  block.duration_s = n * trace.sample_period_s;
  block.power_w = sum_w / n;
  block.sigma_w = std::hypot(trace.noise_sigma_w / std::sqrt(n), trace.rounding_sigma_w);
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
  const std::ptrdiff_t usual = usual_samples(trace, block_s);
  const double half_full = 0.5 * block_s / std::max(trace.sample_period_s, 1e-12);
  while (at != trace.time_s.end() && *at < to_s) {
    // Counted from from_s, not added up, so that long traces do not drift; gaps are skipped at
    // once.
    const double index = std::floor((*at - from_s) / block_s + kEdge);
    const double block_end_s = std::min(from_s + (index + 1.0 - kEdge) * block_s, to_s);
    auto end = first_not_before(at, trace.time_s.end(), block_end_s, usual);
    if (end == at) ++end;
    const Run run = longest_unbroken(
        trace, {static_cast<std::size_t>(at - begin), static_cast<std::size_t>(end - begin)});
    if (static_cast<double>(run.size()) >= half_full) blocks.push_back(mean_of(trace, run));
    at = end;
  }
  return blocks;
}

}  // namespace vildar
