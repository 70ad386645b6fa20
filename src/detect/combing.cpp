#include "detect/combing.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace vildar {
namespace {

// By how much the even rows of a lamp stand to the right of the rows between, with its sigma.
struct Shift {
  double mean_px, sigma_px;
};

std::optional<Shift> shift_of(const LumaView& luma, const PixelBox& box) {
  constexpr int kFewestRows = 8;
  constexpr int kFaint_codes = 32;  // what coding leaves of fainter ones stands anyhow
  constexpr double kLevel = 0.25;   // of the lamp's height over the darkest of its box
  int darkest = luma.white_code, brightest = 0;
  for (int v = box.v_min; v <= box.v_max; ++v)
    for (int u = box.u_min; u <= box.u_max; ++u) {
      darkest = std::min(darkest, luma.code(u, v));
      brightest = std::max(brightest, luma.code(u, v));
    }
  if (brightest - darkest < kFaint_codes) return std::nullopt;
  const double level = darkest + kLevel * (brightest - darkest);
  std::vector<double> middles_px;  // of the rows that reach the level
  int first = 0;
  for (int v = box.v_min; v <= box.v_max; ++v) {
    double sum = 0.0, moment_px = 0.0;
    for (int u = box.u_min; u <= box.u_max; ++u) {
      const double over = std::max(0.0, luma.code(u, v) - level);
      sum += over;
      moment_px += over * u;
    }
    if (sum > 0.0) {
      if (middles_px.empty()) first = v;
      middles_px.push_back(moment_px / sum);
    } else if (!middles_px.empty()) {
      break;
    }
  }
  const auto rows = static_cast<int>(middles_px.size());
  if (rows < kFewestRows) return std::nullopt;
  double sum_px = 0.0, square_px2 = 0.0;
  for (int i = 1; i + 1 < rows; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const double beside_px = middles_px[at] - 0.5 * (middles_px[at - 1] + middles_px[at + 1]);
    const double even_px = (first + i) % 2 == 0 ? beside_px : -beside_px;
    sum_px += even_px;
    square_px2 += even_px * even_px;
  }
  const double count = rows - 2, mean_px = sum_px / count;
  const double variance_px2 = std::max(0.0, square_px2 / count - mean_px * mean_px);
  return Shift{mean_px, std::sqrt(variance_px2 / count)};
}

}  // namespace

void Combing::add(const Frame& frame, std::span<const Blob> blobs) {
  constexpr double kLeast_px = 0.3, kSigmas = 5.0;
  constexpr std::int64_t kEvery = 4;
  if (frame.rotation_deg != 0 || frame.index % kEvery != 0) return;
  for (const Blob& blob : blobs) {
    const auto shift = shift_of(frame.luma, blob.box);
    if (!shift) continue;
    ++judged_;
    combed_ += std::abs(shift->mean_px) > std::max(kLeast_px, kSigmas * shift->sigma_px);
  }
}

bool Combing::told() const {
  constexpr std::int64_t kFewest = 8;
  constexpr double kLeastShare = 0.03;
  return combed_ >= kFewest &&
         static_cast<double>(combed_) >= kLeastShare * static_cast<double>(judged_);
}

}  // namespace vildar
