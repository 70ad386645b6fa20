#pragma once

#include <vector>

#include "estimate/power_method.h"

namespace vildar {

/// Means of a series over consecutive stretches, and their standard deviations.
struct SeriesBlocks {
  std::vector<double> time_s, power_w, sigma_w;
};

/// Of its means over 10 ms the least; the series holds samples.
double least_mean_w(const PowerSeries& series);

/// Stretches of `block_s`. Sigma: white noise of `sample_std_w`, and one percent of the light for
/// what pitching does that no model here knows.
SeriesBlocks series_blocks(const PowerSeries& series, double block_s, double sample_std_w);

}  // namespace vildar
