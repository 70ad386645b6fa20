#include "condition/noise.h"

#include <algorithm>
#include <cmath>

#include "condition/condition.h"

namespace vildar {
namespace {

/// Calls `use(i)` for samples after the first, all of a short trace and about 130,000 of a long
/// one: spread evenly but not in step with anything in it.
template <class Use>
void for_a_selection(std::size_t samples, Use use) {
  constexpr std::size_t kMost = std::size_t{1} << 17, kPrime = 7919;
  const std::size_t stride = samples / kMost + 1;
  for (std::size_t k = 0; k * stride < samples; ++k)
    if (const std::size_t i = k * stride + k * kPrime % stride; i > 0 && i < samples) use(i);
}

/// Of one sample. Differences of neighbours are blind to slow light; their median is blind to
/// edges.
double white_sigma_w(const PowerTrace& trace) {
  constexpr double kSigmaFromMedian = 0.6744897501960817;  // median of |x|, x standard normal
  std::vector<double> steps_w;
  double smallest_step_w = 0.0;
  for_a_selection(trace.time_s.size(), [&](std::size_t i) {
    if (trace.time_s[i] - trace.time_s[i - 1] > 1.5 * trace.sample_period_s) return;
    const double step_w = std::abs(static_cast<double>(trace.power_w[i]) - trace.power_w[i - 1]);
    steps_w.push_back(step_w);
    if (step_w > 0.0 && (smallest_step_w == 0.0 || step_w < smallest_step_w))
      smallest_step_w = step_w;
  });
  if (steps_w.empty()) return 0.0;
  const double sigma_w = median_of(steps_w) / (kSigmaFromMedian * std::sqrt(2.0));
  // Neighbours mostly equal: the converter's step hides the noise, which then is that of rounding.
  return sigma_w > 0.0 ? sigma_w : smallest_step_w / std::sqrt(12.0);
}

/// A level, and how far it may be from the truth.
struct Level {
  double mean_w = 0.0;
  double sigma_w = 0.0;
};

Level dark_level(const PowerTrace& trace) {
  constexpr double kBlock_s = 0.05;
  constexpr double kMiddleOfLowestQuarter = 0.125;
  const double first_s = trace.time_s.front();
  const double last_s = trace.time_s.back() + 0.5 * trace.sample_period_s;
  const double block_s = std::max(kBlock_s, trace.sample_period_s);
  const std::vector<PowerBlock> blocks =
      block_means(trace, first_s, std::max(first_s, last_s), block_s);
  if (blocks.empty()) {
    std::vector<double> powers_w(trace.power_w.begin(), trace.power_w.end());
    return {quantile_of(powers_w, kMiddleOfLowestQuarter), trace.noise_sigma_w};
  }
  std::vector<double> means_w;
  std::vector<double> sigmas_w;
  for (const PowerBlock& block : blocks) {
    means_w.push_back(block.power_w);
    sigmas_w.push_back(block.sigma_w);
  }
  // The lowest quarter alone would lie below the level by the noise of the means: all means that
  // are of that level count.
  const double low_w = quantile_of(means_w, kMiddleOfLowestQuarter);
  const double block_sigma_w = median_of(sigmas_w);
  const double lowest_w = *std::min_element(means_w.begin(), means_w.end());
  // A dark stretch has a floor that noise alone goes below. Where the trace goes on falling there
  // was light of vehicles throughout, and the ambient may be anything from none to the lowest seen.
  constexpr double kFloorSigmas = 6.0;
  if (low_w - lowest_w > kFloorSigmas * block_sigma_w)
    return {0.5 * lowest_w, std::max(0.5 * std::abs(lowest_w), low_w - lowest_w)};
  const double limit_w = low_w + 4.0 * block_sigma_w;
  std::erase_if(means_w, [limit_w](double mean_w) { return mean_w > limit_w; });
  return {median_of(means_w), block_sigma_w / std::sqrt(static_cast<double>(means_w.size()))};
}

}  // namespace

double quantile_of(std::vector<double>& values, double fraction) {
  const auto rank = static_cast<std::ptrdiff_t>(fraction * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return values[static_cast<std::size_t>(rank)];
}

double median_of(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 != 0) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

void set_levels(PowerTrace& trace) {
  if (trace.time_s.empty()) return;
  std::vector<double> spacings_s;
  for_a_selection(trace.time_s.size(), [&](std::size_t i) {
    spacings_s.push_back(trace.time_s[i] - trace.time_s[i - 1]);
  });
  if (!spacings_s.empty()) trace.sample_period_s = median_of(spacings_s);
  trace.noise_sigma_w = white_sigma_w(trace);
  const Level dark = dark_level(trace);
  trace.ambient_w = dark.mean_w;
  trace.ambient_sigma_w = dark.sigma_w;
}

}  // namespace vildar
