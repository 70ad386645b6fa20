#include "condition/sample_ranges.h"

#include "condition/noise.h"

namespace vildar {

std::int64_t drop_ranges(PowerTrace& trace, const std::vector<SampleRange>& ranges) {
  if (ranges.empty()) return 0;
  std::size_t kept = ranges.front().first, read = kept;
  const auto keep_until = [&](std::size_t end) {
    for (; read < end; ++read, ++kept) {
      trace.time_s[kept] = trace.time_s[read];
      trace.power_w[kept] = trace.power_w[read];
    }
  };
  for (const SampleRange& range : ranges) {
    keep_until(range.first);
    read += range.count;
  }
  keep_until(trace.power_w.size());
  const std::size_t dropped = trace.power_w.size() - kept;
  trace.time_s.resize(kept);
  trace.power_w.resize(kept);
  return static_cast<std::int64_t>(dropped);
}

float dark_level_w(const std::vector<float>& power_w) {
  constexpr std::size_t kEnough = std::size_t{1} << 14;
  std::vector<double> some_w;
  for (std::size_t i = 0; i < power_w.size(); i += power_w.size() / kEnough + 1)
    some_w.push_back(power_w[i]);
  return static_cast<float>(quantile_of(some_w, 0.1));
}

}  // namespace vildar
