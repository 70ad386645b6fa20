#include "detect/levels.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace vildar {
namespace {

constexpr int kGridRows = 64;
constexpr int kGridColumns = 120;
constexpr double kQuantisation = 0.28867513459481287;  // sigma of rounding, 1 / sqrt(12)
constexpr double kClipMargin = 0.02;                   // of black..white; what compression rings
constexpr std::int64_t kPlateauPixels = 24;
constexpr double kPlateauShare = 0.25;

/// Value below which `share` of the values lie; reorders them.
int quantile(std::vector<int>& values, double share) {
  const auto rank = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return values[static_cast<std::size_t>(rank)];
}

/// Sigma of one pixel from absolute differences of neighbours. Most neighbours in a night frame
/// differ by rounding alone; the mean of the lower 80 % keeps a fraction of a code where a median
/// would be 0 or 1, and leaves out edges.
double noise_from_steps(std::vector<int>& steps) {
  constexpr double kKept = 0.8;
  // Mean of |x| below its 80 % quantile, for a normal x with sigma sqrt(2).
  constexpr double kMeanStepPerSigma = 0.7900;
  quantile(steps, kKept);
  const auto kept = static_cast<std::size_t>(kKept * static_cast<double>(steps.size() - 1)) + 1;
  double sum = 0.0;
  for (std::size_t i = 0; i < kept; ++i) sum += steps[i];
  return sum / static_cast<double>(kept) / kMeanStepPerSigma;
}

}  // namespace

Levels LevelMeter::measure(const LumaView& luma, const DetectOptions& options) {
  const int step_v = std::max(1, luma.height_px / kGridRows);
  const int step_u = std::max(1, luma.width_px / kGridColumns);
  codes_.clear();
  steps_.clear();
  for (int v = step_v / 2; v < luma.height_px; v += step_v) {
    for (int u = step_u / 2; u < luma.width_px; u += step_u) {
      const int code = luma.code(u, v);
      codes_.push_back(code);
      if (u + 1 < luma.width_px) steps_.push_back(std::abs(luma.code(u + 1, v) - code));
    }
  }
  Levels levels;
  levels.noise_codes = kQuantisation;
  if (!steps_.empty()) levels.noise_codes = std::hypot(noise_from_steps(steps_), kQuantisation);
  levels.background_code = quantile(codes_, 0.5);
  const int crowd_code = quantile(codes_, 1.0 - options.max_bright_share);
  const double span = luma.white_code - luma.black_code;
  const double least =
      std::max(levels.background_code + options.threshold_sigma * levels.noise_codes,
               luma.black_code + options.threshold_fraction * span);
  // However much of the frame is bright, its clipped pixels stay above the threshold.
  const double most = luma.black_code + 0.8 * span;
  levels.threshold_code =
      static_cast<int>(std::ceil(std::max(least, std::min<double>(crowd_code + 1, most))));
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
  for (const PixelRun& run : bright)
    for (int u = run.u_begin; u < run.u_end; ++u) {
      const int code = luma.code(u, run.v);
      if (code >= nominal_code && code - nominal_code < static_cast<int>(size))
        ++counts_[static_cast<std::size_t>(code - nominal_code)];
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
