#include "estimate/power_blocks.h"

#include <algorithm>
#include <cmath>

namespace vildar {

std::vector<PowerBlock> block_means(const PowerTrace& trace, double from_s, double to_s,
                                    double block_s, double offset_s) {
  std::vector<PowerBlock> blocks;
  if (!(trace.sample_period_s > 0.0) || !(block_s > 0.0)) return blocks;
  const double fewest = std::max(1.0, 0.5 * block_s / trace.sample_period_s);
  auto i = static_cast<std::size_t>(
      std::lower_bound(trace.time_s.begin(), trace.time_s.end(), from_s) - trace.time_s.begin());
  for (int block = 0; i < trace.time_s.size() && trace.time_s[i] < to_s; ++block) {
    const double end_s = from_s + (block + 1) * block_s;
    double time_sum_s = 0.0, power_sum_w = 0.0;
    int samples = 0;
    for (; i < trace.time_s.size() && trace.time_s[i] < std::min(end_s, to_s); ++i) {
      time_sum_s += trace.time_s[i];
      power_sum_w += static_cast<double>(trace.power_w[i]);
      ++samples;
    }
    if (samples < fewest) continue;
    blocks.push_back({time_sum_s / samples + offset_s, block_s, power_sum_w / samples,
                      std::hypot(trace.noise_sigma_w / std::sqrt(static_cast<double>(samples)),
                                 trace.rounding_sigma_w),
                      samples});
  }
  return blocks;
}

}  // namespace vildar
