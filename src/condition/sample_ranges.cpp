#include "condition/sample_ranges.h"

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

}  // namespace vildar
