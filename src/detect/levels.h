#pragma once

#include <cstdint>
#include <vector>

#include "detect/detector.h"
#include "detect/run_scan.h"

namespace vildar {

/// Code values that steer the detection of one frame.
struct Levels {
  double background_code = 0.0;  ///< median of the frame
  double noise_codes = 0.0;      ///< sigma of one pixel, quantisation included
  int threshold_code = 0;        ///< a pixel at or above it is bright
};

/// Background, noise and threshold from a grid of a few thousand pixels.
class LevelMeter {
 public:
  Levels measure(const LumaView& luma, const DetectOptions& options);

 private:
  std::vector<int> codes_;  ///< how many samples have each code, deep codes in bins
  std::vector<int> steps_;  ///< how many neighbours differ by so much
};

/// Learns the code from which a pixel counts as clipped: 2 % below nominal white, unless the camera
/// was seen to pile up its brightest pixels at a code well above, then 2 % below that.
class ClipMeter {
 public:
  /// Adds the frame's bright pixels and returns the code in force.
  int update(const LumaView& luma, const std::vector<PixelRun>& bright);

 private:
  std::vector<std::int64_t> counts_;  ///< of codes from `lowest_code_`
  int lowest_code_ = 0;
};

}  // namespace vildar
