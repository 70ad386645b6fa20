#pragma once

#include <cstdint>
#include <vector>

#include "detect/levels.h"
#include "detect/peaks.h"
#include "types/frame.h"

namespace vildar {

/// Finds tail lamps by their colour. Red light has little luma: a lamp plainly red to the eye may
/// stand hardly above the noise of the luma plane, and far above that of Cr, which is dark but for
/// red lights.
class RedLights {
 public:
  /// Appends to `finder` the red lights in which it found none by their luma: where Cr stands out
  /// by 5.5 % of its range and 4 sigmas of the luma's noise, and luma by 5 sigmas and 3 % of
  /// its range above what surrounds it. Nothing for grey frames, and where red is everywhere.
  void add_to(PeakFinder& finder, const Frame& frame, const Levels& levels, PeakRules rules);

 private:
  bool look_at(const ChromaView& chroma, int width, int height);
  void find_pixels(const LumaView& luma, const PixelBox& box, const Levels& levels);

  LumaView red_;                     // Cr as a plane of its own
  std::vector<std::uint8_t> apart_;  // what it is made of where Cb and Cr are interleaved
  std::vector<PixelRun> red_runs_, runs_;
  RunGroups red_groups_, groups_;
  std::vector<PixelBox> places_;
  int level_code_ = 0;
};

/// Of what was found so, whether it is a lamp: by its kind, and not taller than 1.6 times its width
/// and a pixel, as the image of one on a wet road is.
bool is_dim_tail_lamp(const Blob& blob);

}  // namespace vildar
