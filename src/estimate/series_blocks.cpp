#include "estimate/series_blocks.h"

#include <algorithm>
#include <cmath>

namespace vildar {

SeriesBlocks series_blocks(const PowerSeries& series, double block_s, double sample_std_w) {
  constexpr double kUnmodelled = 0.01;
  SeriesBlocks blocks;
  const std::size_t n = series.time_s.size();
  for (std::size_t first = 0, last = 0; first < n; first = last) {
    double time_s = 0.0, power_w = 0.0;
    for (; last < n && series.time_s[last] < series.time_s[first] + block_s; ++last) {
      time_s += series.time_s[last];
      power_w += series.power_w[last];
    }
    const auto count = static_cast<double>(last - first);
    blocks.time_s.push_back(time_s / count);
    blocks.power_w.push_back(power_w / count);
    blocks.sigma_w.push_back(
        std::hypot(sample_std_w / std::sqrt(count), kUnmodelled * power_w / count));
  }
  return blocks;
}

double least_mean_w(const PowerSeries& series) {
  constexpr double kMean_s = 0.010;
  const SeriesBlocks means = series_blocks(series, kMean_s, 0.0);
  return *std::ranges::min_element(means.power_w);
}

}  // namespace vildar
