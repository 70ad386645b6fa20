#include "detect/levels.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <numeric>

namespace vildar {
namespace {

constexpr int kGridRows = 48;
constexpr int kGridColumns = 72;
constexpr double kQuantisation = 0.28867513459481287;  // sigma of rounding, 1 / sqrt(12)
constexpr double kClipMargin = 0.02;                   // of black..white; what compression rings
constexpr std::int64_t kPlateauPixels = 24;
constexpr double kPlateauShare = 0.25;

constexpr int kFinestBits = 10;  // deeper codes are counted in bins

int sum_of(const std::vector<int>& counts) {
  return std::accumulate(counts.begin(), counts.end(), 0);
}

/// Bin that holds the value below which `share` of the counted values lie.
int quantile(const std::vector<int>& counts, double share) {
  const double rank = share * (sum_of(counts) - 1);
  int bin = 0;
  for (double below = counts[0]; below <= rank; below += counts[bin]) ++bin;
  return bin;
}

/// Sigma of one pixel, in bins, from absolute differences of neighbours. Most neighbours in a night
/// frame differ by rounding alone; the mean of the lower 80 % keeps a fraction of a code where a
/// median would be 0 or 1, and leaves out edges.
double noise_from_steps(const std::vector<int>& steps) {
  constexpr double kKept = 0.8;
  // Mean of |x| below its 80 % quantile, for a normal x with sigma sqrt(2).
  constexpr double kMeanStepPerSigma = 0.7900;
  const double kept = kKept * sum_of(steps);
  double sum = 0.0, left = kept;
  for (std::size_t step = 0; left > 0.0; ++step) {
    const double taken = std::min<double>(steps[step], left);
    sum += taken * static_cast<double>(step);
    left -= taken;
  }
  return sum / kept / kMeanStepPerSigma;
}

template <class T>
void count_samples(const LumaView& luma, int shift, std::vector<int>& codes,
                   std::vector<int>& steps) {
  const int step_v = std::max(1, luma.height_px / kGridRows);
  const int step_u = std::max(1, luma.width_px / kGridColumns);
  const int last = static_cast<int>(codes.size()) - 1;
  for (int v = step_v / 2; v < luma.height_px; v += step_v) {
    const std::uint8_t* row = luma.row(v);
    const auto bin_at = [&](int u) {
      T code;
      std::memcpy(&code, row + u * static_cast<int>(sizeof(T)), sizeof(T));
      return std::min(code >> shift, last);
    };
    // Rows far apart are not fetched ahead by themselves.
    const std::uint8_t* next_row = luma.row(std::min(v + step_v, luma.height_px - 1));
    for (int u = step_u / 2; u + 1 < luma.width_px; u += step_u) {
      __builtin_prefetch(next_row + u * static_cast<int>(sizeof(T)));
      const int bin = bin_at(u), next = bin_at(u + 1);
      ++codes[bin];
      ++steps[std::abs(bin - next)];
    }
    if (luma.width_px == 1) ++codes[bin_at(0)];
  }
}

}  // namespace

Levels LevelMeter::measure(const LumaView& luma, const DetectOptions& options) {
  const int shift = std::max(0, luma.bit_depth - kFinestBits);
  codes_.assign(std::size_t{1} << (luma.bit_depth - shift), 0);
  steps_.assign(codes_.size(), 0);
  if (luma.bytes_per_sample() == 1)
    count_samples<std::uint8_t>(luma, shift, codes_, steps_);
  else
    count_samples<std::uint16_t>(luma, shift, codes_, steps_);
  const int bin_codes = 1 << shift;
  Levels levels;
  levels.noise_codes = kQuantisation * bin_codes;
  if (luma.width_px > 1)
    levels.noise_codes = std::hypot(noise_from_steps(steps_) * bin_codes, kQuantisation);
  levels.background_code = quantile(codes_, 0.5) * bin_codes;
  const int crowd_code = (quantile(codes_, 1.0 - options.max_bright_share) + 1) * bin_codes;
  const double span = luma.white_code - luma.black_code;
  const double least =
      std::max(levels.background_code + options.threshold_sigma * levels.noise_codes,
               luma.black_code + options.threshold_fraction * span);
  // However much of the frame is bright, its clipped pixels stay above the threshold.
  const double most = luma.black_code + 0.8 * span;
  levels.threshold_code =
      static_cast<int>(std::ceil(std::max(least, std::min<double>(crowd_code, most))));
  return levels;
}

int ClipMeter::update(const LumaView& luma, const std::vector<PixelRun>& bright) {
  const int span = luma.white_code - luma.black_code;
  const int margin = std::max(1, static_cast<int>(std::lround(kClipMargin * span)));
  const int nominal_code = luma.white_code - margin;
  const std::size_t deepest = (std::size_t{1} << luma.bit_depth) - 1;
  const std::size_t size = deepest - static_cast<std::size_t>(nominal_code) + 1;
  if (counts_.size() != size || lowest_code_ != nominal_code) {
    counts_.assign(size, 0);
    lowest_code_ = nominal_code;
  }
  for (const PixelRun& run : bright) {
    if (run.most_code < nominal_code) continue;
    for_each_code(luma, run, [&](int, int code) {
      if (code >= nominal_code && code - nominal_code < static_cast<int>(size))
        ++counts_[code - nominal_code];
    });
  }
  std::int64_t total = 0;
  for (const std::int64_t count : counts_) total += count;
  const auto mode = std::max_element(counts_.begin(), counts_.end());
  const int mode_code = nominal_code + static_cast<int>(mode - counts_.begin());
  const bool plateau = *mode >= kPlateauPixels &&
                       static_cast<double>(*mode) >= kPlateauShare * static_cast<double>(total);
  return plateau && mode_code > luma.white_code + margin ? mode_code - margin : nominal_code;
}

}  // namespace vildar
