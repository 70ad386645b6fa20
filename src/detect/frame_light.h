#pragma once

#include <span>

#include "types/frame.h"

namespace vildar {

/// How the light of a pixel scatters, in units of nominal white.
struct PixelNoise {
  double dark_variance = 0.0;  ///< of a pixel without light, rounding left out
  double electrons = 20000.0;  ///< of a pixel at nominal white
  /// Variance of rounding to whole codes at 0 .. 1, evenly spaced; at least one entry.
  std::span<const float> rounding;

  double variance(double light) const;
};

/// A frame's pixels as light. Pixels from `clip_code` on say only that their light is at least
/// `clip_light`.
struct FrameLight {
  LumaView luma;
  std::span<const float> linear;  ///< of each code; goes on below black
  int clip_code = 255;
  double clip_light = 1.0;
  PixelNoise noise;
};

}  // namespace vildar
