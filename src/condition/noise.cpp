#include "condition/noise.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <optional>
#include <span>

#include "condition/condition.h"
#include "core/quantity.h"

namespace vildar {
namespace {

/// Calls `use(i)` for samples after the first, all of a short trace and some 33,000 of a long one,
/// which tell a sigma to 0.6 %: spread evenly but not in step with anything in it.
template <class Use>
void for_a_selection(std::size_t samples, Use use) {
  constexpr std::size_t kMost = std::size_t{1} << 15;
  constexpr std::uint32_t kGolden = 2654435769;  // of 2^32, the golden section
  const std::size_t stride = samples / kMost + 1;
  std::uint32_t turned = 0;
  for (std::size_t first = 0; first < samples; first += stride, turned += kGolden)
    if (const std::size_t i = first + (std::uint64_t{turned} * stride >> 32); i > 0 && i < samples)
      use(i);
}

struct Noise {
  double sigma_w = 0.0;           ///< of one sample
  double rounding_sigma_w = 0.0;  ///< left in a mean of many
};

/// Share of the steps that are of noise: it makes as many up as down, where light that rises or
/// falls makes steps one way.
double share_to_and_fro(const std::vector<double>& steps_w) {
  constexpr std::size_t kTogether = 500;
  double share = 0.0;
  for (std::size_t first = 0; first < steps_w.size(); first += kTogether) {
    const auto some =
        std::span(steps_w).subspan(first, std::min(kTogether, steps_w.size() - first));
    const auto up = std::ranges::count_if(some, [](double step_w) { return step_w > 0.0; });
    const auto down = std::ranges::count_if(some, [](double step_w) { return step_w < 0.0; });
    share += 2.0 * static_cast<double>(std::min(up, down)) / static_cast<double>(steps_w.size());
  }
  return share;
}

/// Differences of neighbours are blind to slow light; their median is blind to edges.
Noise noise_of(const PowerTrace& trace) {
  constexpr double kSigmaFromMedian = 0.6744897501960817;  // median of |x|, x standard normal
  std::vector<double> steps_w;
  double smallest_step_w = 0.0;
  for_a_selection(trace.time_s.size(), [&](std::size_t i) {
    if (trace.time_s[i] - trace.time_s[i - 1] > 1.5 * trace.sample_period_s) return;
    const double step_w = static_cast<double>(trace.power_w[i]) - trace.power_w[i - 1];
    steps_w.push_back(step_w);
    if (step_w != 0.0 && (smallest_step_w == 0.0 || std::abs(step_w) < smallest_step_w))
      smallest_step_w = std::abs(step_w);
  });
  if (steps_w.empty()) return {};
  std::vector<double> sizes_w(steps_w.size());
  std::ranges::transform(steps_w, sizes_w.begin(), [](double step_w) { return std::abs(step_w); });
  if (const double sigma_w = median_of(sizes_w) / (kSigmaFromMedian * std::sqrt(2.0));
      sigma_w > 0.0)
    return {sigma_w};
  // Neighbours mostly equal: the converter's step hides the noise, which then is that of rounding.
  // Noise of s steps makes 1 - 2 s / sqrt(pi) of them equal, and leaves exp(-2 pi^2 s^2) of the
  // rounding in a mean (Widrow and Kollar, Quantization Noise, Cambridge 2008, chapter 4).
  const double steps = 0.5 * std::sqrt(kPi) * share_to_and_fro(steps_w);
  const double rounding_w = smallest_step_w / std::sqrt(12.0);
  return {rounding_w, rounding_w * std::exp(-2.0 * kPi * kPi * steps * steps)};
}

/// A level, and how far it may be from the truth.
struct Level {
  double mean_w = 0.0;
  double sigma_w = 0.0;
};

double sigma_of_mean(const PowerTrace& trace, double samples) {
  return std::hypot(trace.noise_sigma_w / std::sqrt(samples), trace.rounding_sigma_w);
}

/// How fast light may grow on `floor`: by its slope and two sigma.
double most_growth_w_per_s(std::span<const PowerBlock> floor, const PowerTrace& trace) {
  constexpr double kSigmas = 2.0;
  const auto count = static_cast<double>(floor.size());
  double samples = 0.0, mean_s = 0.0;
  for (const PowerBlock& block : floor) {
    samples += block.samples;
    mean_s += block.time_s / count;
  }
  double variance_s2 = 0.0, covariance_ws = 0.0;
  for (const PowerBlock& block : floor) {
    variance_s2 += std::pow(block.time_s - mean_s, 2) / count;
    covariance_ws += (block.time_s - mean_s) * block.power_w / count;
  }
  return std::max(0.0, covariance_ws / variance_s2) +
         kSigmas * sigma_of_mean(trace, samples) / std::sqrt(variance_s2);
}

constexpr double kHeld_s = 0.3;  // for which a level is a floor, and no turning point of some light

/// K of light that grows as K / t^2, t the time until its vehicle is past at `past_s`: the most
/// that the light above `level_w` asks for within two seconds before.
double brightness_ws2(std::span<const PowerBlock> blocks, double past_s, double level_w) {
  constexpr double kApproach_s = 2.0;
  double most_ws2 = 0.0;
  for (const PowerBlock& block : blocks)
    if (const double until_s = past_s - block.time_s; until_s > 0.0 && until_s < kApproach_s)
      most_ws2 = std::max(most_ws2, (block.power_w - level_w) * until_s * until_s);
  return most_ws2;
}

/// Light that a floor may hold of a vehicle of which nothing more is seen. What grows by
/// g = 2 K / t^3 is cbrt(K) (g / 2)^(2/3). K is that of the vehicle that left; three sigma allow
/// for one 27 times as bright.
double unseen_light_w(std::span<const PowerBlock> floor, double left_ws2, const PowerTrace& trace) {
  return std::cbrt(left_ws2 * std::pow(0.5 * most_growth_w_per_s(floor, trace), 2));
}

/// Light that a floor may hold of the vehicle that is seen after it: where light grows by g, g t /
/// 2 with t until that is past. None where the record ends with the floor.
double hidden_light_w(std::span<const PowerBlock> blocks, std::span<const PowerBlock> floor,
                      const PowerTrace& trace) {
  constexpr double kAhead_s = 10.0, kAtTheEnd_s = 0.3, kLongestUnseen_s = 4.0;
  const std::span<const PowerBlock> after(floor.data() + floor.size(),
                                          blocks.data() + blocks.size());
  if (after.empty()) return 0.0;
  const double until_s = floor.back().time_s + kAhead_s;
  const PowerBlock* brightest = &after.front();
  for (const PowerBlock& block : after)
    if (block.time_s < until_s && block.power_w > brightest->power_w) brightest = &block;
  double past_s = brightest->time_s;
  if (blocks.back().time_s - past_s < kAtTheEnd_s) past_s += kLongestUnseen_s;  // not past yet
  const double middle_s = 0.5 * (floor.front().time_s + floor.back().time_s);
  return 0.5 * most_growth_w_per_s(floor, trace) * (past_s - middle_s);
}

/// The lowest level, of the stretches that hold it the surest: how sure it is that none shines into
/// it, no follower of the vehicle whose light falls to it at once, or else the next that is seen to
/// come.
std::optional<Level> lowest_floor(const std::vector<PowerBlock>& blocks, double block_sigma_w,
                                  const PowerTrace& trace) {
  constexpr double kFall_s = 0.5, kLeastFall = 0.2;
  constexpr double kLevelSigmas = 4.0;
  const auto [least, most] = std::ranges::minmax(blocks, {}, &PowerBlock::power_w);
  const double limit_w = least.power_w + kLevelSigmas * block_sigma_w;
  const double fall_w = least.power_w + kLeastFall * (most.power_w - least.power_w);
  const auto lit = [&](const PowerBlock& block) { return block.power_w > limit_w; };
  std::optional<Level> surest;
  for (auto after = blocks.begin(); after != blocks.end();) {
    const auto before = std::find_if_not(after, blocks.end(), lit);
    after = std::find_if(before, blocks.end(), lit);
    if (before == after || std::prev(after)->time_s - before->time_s < kHeld_s) continue;
    const bool falls = std::any_of(blocks.begin(), before, [&](const PowerBlock& block) {
      return before->time_s - block.time_s < kFall_s && block.power_w > fall_w;
    });
    if (!falls && after == blocks.end()) continue;
    const double hidden_w =
        falls ? unseen_light_w(
                    {before, after},
                    brightness_ws2({blocks.begin(), before}, before->time_s, least.power_w), trace)
              : hidden_light_w(blocks, {before, after}, trace);
    const double sigma_w = std::hypot(kLevelSigmas * block_sigma_w, hidden_w);
    if (surest && surest->sigma_w <= sigma_w) continue;
    std::vector<double> means_w;
    for (auto block = before; block != after; ++block) means_w.push_back(block->power_w);
    surest = Level{median_of(means_w), sigma_w};
  }
  return surest;
}

/// Of all floors below `limit_w` the one that holds least hidden light, and how much; infinite
/// where there is no floor. One block above the limit may be a slip of the noise.
double least_hidden_light_w(std::span<const PowerBlock> blocks, double block_s, double limit_w,
                            const PowerTrace& trace) {
  constexpr std::size_t kFewestBlocks = 3;
  const auto lit = [&](std::size_t i) { return blocks[i].power_w > limit_w; };
  const auto rises = [&](std::size_t i) {
    return lit(i) && (i + 1 == blocks.size() || lit(i + 1));
  };
  double least_w = INFINITY;
  for (std::size_t first = 0, next = 0; first < blocks.size(); first = next + 1) {
    for (next = first; next < blocks.size() && !rises(next);) ++next;
    std::size_t from = first, to = next;
    while (from < to && lit(from)) ++from;
    while (to > from && lit(to - 1)) --to;
    if (to - from < kFewestBlocks || static_cast<double>(to - from) * block_s < kHeld_s) continue;
    least_w = std::min(least_w, hidden_light_w(blocks, blocks.subspan(from, to - from), trace));
  }
  return least_w;
}

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
  // was light of vehicles throughout, and the ambient may be anything from none to the lowest seen,
  // unless it stood at a floor.
  constexpr double kFloorSigmas = 6.0;
  const Level any{0.5 * lowest_w, std::max(0.5 * std::abs(lowest_w), low_w - lowest_w)};
  const double limit_w = low_w + 4.0 * block_sigma_w;
  const double hidden_w = least_hidden_light_w(blocks, block_s, limit_w, trace);
  if (low_w - lowest_w > kFloorSigmas * block_sigma_w || hidden_w > any.sigma_w) {
    const auto floor = lowest_floor(blocks, block_sigma_w, trace);
    return floor && floor->sigma_w < any.sigma_w ? *floor : any;
  }
  std::erase_if(means_w, [limit_w](double mean_w) { return mean_w > limit_w; });
  const double white_w =
      std::sqrt(std::max(0.0, std::pow(block_sigma_w, 2) - std::pow(trace.rounding_sigma_w, 2)));
  return {median_of(means_w), std::hypot(white_w / std::sqrt(static_cast<double>(means_w.size())),
                                         trace.rounding_sigma_w, hidden_w)};
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

void set_noise(PowerTrace& trace) {
  if (trace.time_s.empty()) return;
  std::vector<double> spacings_s;
  for_a_selection(trace.time_s.size(), [&](std::size_t i) {
    spacings_s.push_back(trace.time_s[i] - trace.time_s[i - 1]);
  });
  if (!spacings_s.empty()) trace.sample_period_s = median_of(spacings_s);
  const Noise noise = noise_of(trace);
  trace.noise_sigma_w = noise.sigma_w;
  trace.rounding_sigma_w = noise.rounding_sigma_w;
}

void set_ambient(PowerTrace& trace) {
  if (trace.time_s.empty()) return;
  const Level dark = dark_level(trace);
  trace.ambient_w = dark.mean_w;
  trace.ambient_sigma_w = dark.sigma_w;
}

float dark_level_w(const std::vector<float>& power_w) {
  constexpr std::size_t kEnough = std::size_t{1} << 14;
  std::vector<double> some_w;
  for (std::size_t i = 0; i < power_w.size(); i += power_w.size() / kEnough + 1)
    some_w.push_back(power_w[i]);
  return static_cast<float>(quantile_of(some_w, 0.1));
}

}  // namespace vildar
