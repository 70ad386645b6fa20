#pragma once

#include <span>
#include <vector>

#include "detect/run_scan.h"

namespace vildar {

/// Finds where lamps end whose light runs together below them. A wet road draws the image of a lamp
/// out toward the viewer and shows what the lamp lights: where all of it clips, lamps are the heads
/// that stand on top of one area.
class HeadFinder {
 public:
  /// `runs` of one area's clipped pixels in reading order, rows downwards. The result, in reading
  /// order and valid until the next call, are the pixels right below each head that has come to its
  /// full width and then runs into something wider, or into another head.
  const std::vector<PixelRun>& cuts(std::span<const PixelRun> runs);

 private:
  /// What hangs together down to the present row.
  struct Head {
    int parent;
    int first_v;
    int width_px;  // of its widest row
    bool trunk;    // heads have been cut off it
  };
  int root_of(int head);
  int join(std::span<const PixelRun> runs, int at);

  std::vector<Head> heads_;
  std::vector<int> head_of_;  ///< of each run
  std::vector<int> above_;    ///< runs in the row before that touch the present one
  std::vector<PixelRun> cuts_;
};

}  // namespace vildar
