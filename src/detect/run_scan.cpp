#include "detect/run_scan.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>

// Highway compiles this file once per instruction set and picks one at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detect/run_scan.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace vildar {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr int kBlock = 64;  // pixels per mask word

/// Bit i is set where pixels[i] >= threshold, for kBlock pixels.
template <class T>
std::uint64_t block_mask(const T* pixels, T threshold) {
  const hn::CappedTag<T, kBlock> tag;
  const int lanes = static_cast<int>(hn::Lanes(tag));
  const auto below =
      hn::Set(tag, static_cast<T>(threshold - 1));  // this Highway has no unsigned >=
  std::uint64_t mask = 0;
  for (int i = 0; i < kBlock; i += lanes) {
    // Read as wide as it was written: the processor need not wait for the store.
    constexpr std::size_t kBytes = std::min<std::size_t>((hn::MaxLanes(tag) + 7) / 8, 8);
    std::uint8_t bits[16] = {};
    hn::StoreMaskBits(tag, hn::Gt(hn::LoadU(tag, pixels + i), below), bits);
    std::uint64_t word = 0;
    std::memcpy(&word, bits, kBytes);
    if (lanes < kBlock) word &= (std::uint64_t{1} << lanes) - 1;
    mask |= word << i;
  }
  return mask;
}

template <class T>
int stretch_px() {
  return 4 * static_cast<int>(hn::Lanes(hn::CappedTag<T, kBlock>()));
}

/// Whether none of at least stretch_px() pixels is bright. Four chains of maxima, so that none
/// waits for the one before it, and one look at them: not much more than the plain maximum costs.
/// Asks for what lies about a row further on: by itself the processor stops at the end of a page.
template <class T>
HWY_INLINE bool all_dark(const T* pixels, int count, T threshold) {
  const hn::CappedTag<T, kBlock> tag;
  const int lanes = static_cast<int>(hn::Lanes(tag));
  auto a = hn::Zero(tag), b = a, c = a, d = a;
  const auto look_at = [&](const T* from) HWY_ATTR {
    constexpr int kAhead_bytes = 2048, kLine_bytes = 64;
    for (int at = 0; at < stretch_px<T>() * static_cast<int>(sizeof(T)); at += kLine_bytes)
      __builtin_prefetch(reinterpret_cast<const char*>(from) + kAhead_bytes + at);
    a = hn::Max(a, hn::LoadU(tag, from));
    b = hn::Max(b, hn::LoadU(tag, from + lanes));
    c = hn::Max(c, hn::LoadU(tag, from + 2 * lanes));
    d = hn::Max(d, hn::LoadU(tag, from + 3 * lanes));
  };
  const T* const last = pixels + count - stretch_px<T>();
  for (; pixels < last; pixels += stretch_px<T>()) look_at(pixels);
  look_at(last);
  const auto below =
      hn::Set(tag, static_cast<T>(threshold - 1));  // this Highway has no unsigned >=
  return hn::AllFalse(tag, hn::Gt(hn::Max(hn::Max(a, b), hn::Max(c, d)), below));
}

template <class T>
void scan_row(const T* pixels, int count, T threshold, int v, std::vector<PixelRun>& runs) {
  int open = -1;  // start of the run that reaches the block's left edge
  int u = 0;
  while (u < count) {
    if (open < 0 && u + stretch_px<T>() <= count &&
        all_dark(pixels + u, stretch_px<T>(), threshold)) {
      u += stretch_px<T>();
      continue;
    }
    std::uint64_t mask = 0;
    if (u + kBlock <= count) {
      mask = block_mask(pixels + u, threshold);
    } else {
      T tail[kBlock] = {};
      std::memcpy(tail, pixels + u, static_cast<std::size_t>(count - u) * sizeof(T));
      mask = block_mask(tail, threshold);
    }
    int bit = 0;
    while (bit < kBlock) {
      const std::uint64_t rest = (open < 0 ? mask : ~mask) >> bit;
      if (rest == 0) break;
      bit += std::countr_zero(rest);
      if (open < 0) {
        open = u + bit;
      } else {
        runs.push_back({v, open, u + bit});
        open = -1;
      }
    }
    u += kBlock;
  }
  if (open >= 0) runs.push_back({v, open, count});
}

template <class T>
void scan_plane(const LumaView& luma, T threshold, std::vector<PixelRun>& runs) {
  const int count = luma.width_px;
  for (int v = 0; v < luma.height_px; ++v) {
    const T* row = reinterpret_cast<const T*>(luma.row(v));
    const bool dark = luma.row_maxima != nullptr
                          ? luma.row_maxima[v] < threshold
                          : count >= stretch_px<T>() && all_dark(row, count, threshold);
    if (!dark) scan_row(row, count, threshold, v, runs);
  }
}

void find_runs_here(const LumaView& luma, int threshold, std::vector<PixelRun>& runs) {
  if (luma.bytes_per_sample() == 1)
    scan_plane(luma, static_cast<std::uint8_t>(threshold), runs);
  else
    scan_plane(luma, static_cast<std::uint16_t>(threshold), runs);
}

}  // namespace HWY_NAMESPACE
}  // namespace vildar
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vildar {
namespace {

HWY_EXPORT(find_runs_here);

int root_of(std::vector<int>& parent, int node) {
  while (parent[node] != node) node = parent[node] = parent[parent[node]];
  return node;
}

}  // namespace

void find_runs(const LumaView& luma, int threshold_code, std::vector<PixelRun>& runs) {
  runs.clear();
  const int deepest_code = luma.bytes_per_sample() == 1 ? 255 : 65535;
  if (threshold_code > deepest_code) return;
  HWY_DYNAMIC_DISPATCH(find_runs_here)(luma, std::max(threshold_code, 1), runs);
  for (PixelRun& run : runs) run.most_code = brightest_of(luma, run);
}

void group_runs(const std::vector<PixelRun>& runs, RunGroups& groups) {
  const int n = static_cast<int>(runs.size());
  std::vector<int>& parent = groups.parent_;
  parent.resize(runs.size());
  int above = 0;      // first run that may touch the current one
  int row_start = 0;  // first run of the current row
  for (int i = 0; i < n; ++i) {
    if (i > 0 && runs[i].v != runs[i - 1].v) {
      above = runs[i - 1].v == runs[i].v - 1 ? row_start : i;
      row_start = i;
    }
    while (above < row_start && runs[above].u_end < runs[i].u_begin) ++above;
    int mine = parent[i] = i;
    for (int j = above; j < row_start && runs[j].u_begin <= runs[i].u_end; ++j) {
      const int theirs = root_of(parent, j);
      parent[std::max(mine, theirs)] = std::min(mine, theirs);
      mine = std::min(mine, theirs);
    }
  }
  // No parent comes after its child: once through, and each has its root.
  for (int& one : parent) one = parent[one];
  // The root is the group's first run, so groups number themselves in reading order.
  groups.slot_.assign(runs.size(), 0);
  groups.first.assign(1, 0);
  for (int i = 0; i < n; ++i) {
    const int root = parent[i];
    if (root == i) {
      groups.slot_[i] = static_cast<int>(groups.first.size()) - 1;
      groups.first.push_back(0);
    }
    ++groups.first[groups.slot_[root] + 1];
  }
  for (std::size_t g = 1; g < groups.first.size(); ++g) groups.first[g] += groups.first[g - 1];
  groups.order.resize(runs.size());
  for (int i = n - 1; i >= 0; --i) {
    const int group = groups.slot_[parent[i]];
    groups.order[--groups.first[group + 1]] = i;
  }
  for (std::size_t g = 1; g + 1 < groups.first.size(); ++g) groups.first[g] = groups.first[g + 1];
  if (n > 0) groups.first.back() = n;
}

}  // namespace vildar
#endif  // HWY_ONCE
