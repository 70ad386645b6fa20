#pragma once

#include <optional>
#include <span>

#include "types/frame.h"

namespace vildar {

/// How the light of a pixel scatters, in units of nominal white.
struct PixelNoise {
  double dark_variance = 0.0;  ///< of a pixel without light, rounding left out
  double electrons = 20000.0;  ///< of a pixel at nominal white
  /// Variance of rounding to whole codes, or of coding with loss, at 0 .. 1, evenly spaced; at
  /// least one entry.
  std::span<const float> rounding;

  double variance(double light) const;
};

/// What coding with loss does to lamps beside what it does to single pixels; the defaults: nothing.
struct CodingErrors {
  double correlated_px = 1.0;  ///< how many pixels err together
  /// The same for what is told by many pixels: coders keep sums better than patches.
  double summed_px = 1.0;
  double flux_share = 0.0;     ///< standard deviation of the light of a lamp as a whole
  double clipped_share = 0.0;  ///< the same where pixels clip
  double centre_px = 0.0;      ///< and of its place, an axis
  /// How many times the sigma of a pixel elsewhere one at the rim of what clips has: errors there
  /// are larger, and alike all around, so that they do not average.
  double rim_factor = 1.0;
  /// Variance by which lamps of which nothing clips are softened, codes rather than light; an axis.
  double softened_px2 = 0.0;
};

/// A frame's pixels as light. Pixels from `clip_code` on say only that their light is at least
/// `clip_light`.
struct FrameLight {
  LumaView luma;
  std::span<const float> linear;  ///< of each code; goes on below black
  int clip_code = 255;
  double clip_light = 1.0;
  PixelNoise noise;
  std::optional<CodingErrors> coding;  ///< of pictures that were coded with loss
  /// Pixels about a lamp that clips and has none beside it, those at its rim apart, that a fit
  /// looks at: where there are more, every so many.
  double most_lone_wing_px = 600.0;
};

}  // namespace vildar
