#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "types/frame.h"

namespace vildar {

/// Pixels u_begin..u_end - 1 of row v, all at or above the threshold, neither end extensible.
struct PixelRun {
  int v = 0;
  int u_begin = 0;
  int u_end = 0;
  int most_code = 0;  ///< greatest of them, as find_runs() knows it
};

/// Calls `use(u, code)` for each pixel of a run.
template <class Use>
void for_each_code(const LumaView& luma, const PixelRun& run, Use use) {
  const std::uint8_t* row = luma.row(run.v);
  if (luma.bytes_per_sample() == 1)
    for (int u = run.u_begin; u < run.u_end; ++u) use(u, int{row[u]});
  else
    for (int u = run.u_begin; u < run.u_end; ++u) use(u, luma.code(u, run.v));
}

/// Greatest code of a run.
inline int brightest_of(const LumaView& luma, const PixelRun& run) {
  int most = 0;
  if (luma.bytes_per_sample() == 1) {
    const std::uint8_t* row = luma.row(run.v);
    std::uint8_t most_here = 0;  // as narrow as the samples: many at a time
    for (int u = run.u_begin; u < run.u_end; ++u) most_here = std::max(most_here, row[u]);
    most = most_here;
  } else {
    for_each_code(luma, run, [&](int, int code) { most = std::max(most, code); });
  }
  return most;
}

/// How many pixels of a run have at least this code.
inline int count_from(const LumaView& luma, const PixelRun& run, int code) {
  int count = 0;
  if (luma.bytes_per_sample() == 1) {
    constexpr int kPart_px = 255;  // as narrow as the samples: many at a time
    const std::uint8_t* row = luma.row(run.v);
    const auto least = static_cast<std::uint8_t>(code);
    for (int u = run.u_begin; u < run.u_end;) {
      std::uint8_t part = 0;
      for (const int end = std::min(u + kPart_px, run.u_end); u < end; ++u)
        part = static_cast<std::uint8_t>(part + (row[u] >= least));
      count += part;
    }
  } else {
    for_each_code(luma, run, [&](int, int here) { count += here >= code; });
  }
  return count;
}

/// Replaces `runs` by all runs of the plane with code >= threshold_code, in reading order.
/// A threshold below 1 counts as 1; one above the deepest code finds nothing.
void find_runs(const LumaView& luma, int threshold_code, std::vector<PixelRun>& runs);

/// Runs that touch, diagonals included, grouped. Group g holds the runs
/// `order[first[g]] .. order[first[g + 1] - 1]`; groups are in order of their first run.
struct RunGroups {
  std::vector<int> order;
  std::vector<int> first;
  std::size_t count() const { return first.empty() ? 0 : first.size() - 1; }

 private:
  friend void group_runs(const std::vector<PixelRun>& runs, RunGroups& groups);
  std::vector<int> parent_;
  std::vector<int> slot_;
};
/// `runs` in reading order. Reuses the buffers of `groups`.
void group_runs(const std::vector<PixelRun>& runs, RunGroups& groups);

}  // namespace vildar
