#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "detect/heads.h"
#include "detect/run_scan.h"
#include "types/blob.h"
#include "types/frame.h"

namespace vildar {

struct PixelAt {
  int u = 0;
  int v = 0;
};

/// One light: the pixels that belong to one peak and to no other, down to half its light.
struct Peak {
  std::size_t first = 0;  ///< into PeakFinder::pixels()
  std::size_t count = 0;
  int level_code = 0;  ///< least code of its pixels
  int peak_code = 0;   ///< greatest, at most the clipping code
  int clipped_px = 0;
  int eroded_px = 0;  ///< its pixels stop this far inside the rim: parted from another clipped disc
  int area_px = 0;    ///< at the frame's threshold or, of a split light, above the valley
  PixelBox box;       ///< of its pixels, as stored
  bool split = false;  ///< shares its bright area with another
  bool head = false;   ///< cut off the light below it, see HeadFinder
};

struct PeakRules {
  int clip_code = 255;
  int least_valley_codes = 10;  ///< depth that tells two peaks apart
  int min_area_px = 2;
  double noise_codes = 0.5;  ///< sigma of one pixel at the threshold
  bool upright = true;       ///< rows run downwards in the world
  /// Code of half the light of each code, above the frame's background; indexed by code.
  std::span<const int> half_code;
};

/// Splits bright areas into lights by a component tree: pixels join in falling order of code, and
/// two areas that meet in a valley deep below both their peaks stay apart. Inside a clipped area
/// the distance to its rim goes on where the code stops, so that two discs joined by a neck part as
/// well; lamps that stand on the light of a wet road are cut off it (HeadFinder). Of a wide area
/// (lit road) only its brightest thousand pixels are looked at, and all that clip: the cost is that
/// of the lights, not of what they shine on.
class PeakFinder {
 public:
  /// Appends the lights of one bright area to peaks(). An area too small, or above the threshold by
  /// no more than the noise of its pixels and the grain of a lit road are, has none.
  void add(const LumaView& luma, std::span<const int> run_indices,
           const std::vector<PixelRun>& runs, int threshold_code, const PeakRules& rules);
  void clear();
  const std::vector<Peak>& peaks() const { return peaks_; }
  std::span<const PixelAt> pixels(const Peak& peak) const {
    return std::span<const PixelAt>(pixels_).subspan(peak.first, peak.count);
  }

 private:
  struct Node {
    int u, v;
    int code;
    int height;  // code, and depth inside a clipped area
    int cell;    // in the grid
    int next;    // of its set
    bool foot;   // right above a cut
  };
  struct Set {
    int parent;       // set forest
    int first, last;  // of its list of nodes
    int top;          // greatest height
    int count;
    bool closed;  // holds lights already taken out
  };
  void load(const LumaView& luma, std::span<const int> run_indices,
            const std::vector<PixelRun>& runs, int floor_code, const PeakRules& rules);
  int floor_code(const LumaView& luma, std::span<const int> run_indices,
                 const std::vector<PixelRun>& runs, int threshold_code, const PeakRules& rules);
  int root_of(int set);
  int set_about(int node, const PeakRules& rules);
  int join_about(int node, const PeakRules& rules);
  void append(int node, int root);
  int join(int mine, int theirs, int height, const PeakRules& rules);
  void close(int set, int valley_code, bool split, const PeakRules& rules);
  void fill_depths(int clip_code);
  void cut_below_heads(const PeakRules& rules);
  void sort_by_height();

  std::vector<Peak> peaks_;
  std::vector<PixelAt> pixels_;
  std::vector<Node> nodes_;  // pixels of the area
  std::vector<Set> sets_;
  std::vector<int> order_;         // nodes in falling order of height
  std::vector<int> place_;         // where the next node of a height goes
  std::vector<int> plateau_;       // nodes that clip
  std::vector<PixelRun> clipped_;  // runs of nodes no valley below
  HeadFinder heads_;
  /// Padded box of the area, 0 between calls: depths of clipped pixels, then the labels of those
  /// that have a set.
  std::vector<std::uint64_t> grid_;
  int grid_width_ = 0;
};

}  // namespace vildar
