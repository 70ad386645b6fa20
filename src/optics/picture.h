#pragma once

#include <algorithm>

namespace vildar {

/// A picture's pixels along a line beside those of one 1920 px wide, for which sizes in pixels are
/// meant; 1 for coarser ones.
inline double px_per_usual(int width_px, int height_px) {
  constexpr double kUsual_px = 1920.0;
  return std::max(1.0, std::max(width_px, height_px) / kUsual_px);
}

}  // namespace vildar
