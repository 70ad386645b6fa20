#include "detect/run_scan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "core/random.h"

namespace vildar {
namespace {

struct Plane {
  std::vector<std::uint8_t> bytes;
  LumaView view;

  Plane(int width_px, int height_px, int bit_depth, int padding_bytes = 0) {
    view.width_px = width_px;
    view.height_px = height_px;
    view.bit_depth = bit_depth;
    view.stride_bytes = width_px * view.bytes_per_sample() + padding_bytes;
    // Padding is as bright as can be: reading it as picture would show.
    bytes.assign(static_cast<std::size_t>(view.stride_bytes) * height_px, 0xff);
    view.data = bytes.data();
    for (int v = 0; v < height_px; ++v)
      for (int u = 0; u < width_px; ++u) set(u, v, 0);
  }
  void set(int u, int v, int code) {
    std::uint8_t* sample = bytes.data() + v * view.stride_bytes + u * view.bytes_per_sample();
    sample[0] = static_cast<std::uint8_t>(code);
    if (view.bit_depth > 8) sample[1] = static_cast<std::uint8_t>(code >> 8);
  }
};

/// Label of each pixel by flood fill, -1 where dark; labels in reading order.
std::vector<int> flood_labels(const LumaView& luma, int threshold, int& labels) {
  std::vector<int> label(static_cast<std::size_t>(luma.width_px) * luma.height_px, -1);
  labels = 0;
  std::vector<std::pair<int, int>> stack;
  for (int v = 0; v < luma.height_px; ++v) {
    for (int u = 0; u < luma.width_px; ++u) {
      if (luma.code(u, v) < threshold || label[v * luma.width_px + u] >= 0) continue;
      stack.assign(1, {u, v});
      label[v * luma.width_px + u] = labels;
      while (!stack.empty()) {
        const auto [a, b] = stack.back();
        stack.pop_back();
        for (int y = std::max(b - 1, 0); y <= std::min(b + 1, luma.height_px - 1); ++y)
          for (int x = std::max(a - 1, 0); x <= std::min(a + 1, luma.width_px - 1); ++x)
            if (luma.code(x, y) >= threshold && label[y * luma.width_px + x] < 0) {
              label[y * luma.width_px + x] = labels;
              stack.push_back({x, y});
            }
      }
      ++labels;
    }
  }
  return label;
}

void expect_same_as_flood_fill(const LumaView& luma, int threshold) {
  std::vector<PixelRun> runs;
  RunGroups groups;
  find_runs(luma, threshold, runs);
  group_runs(runs, groups);
  int labels = 0;
  const std::vector<int> truth = flood_labels(luma, threshold, labels);
  ASSERT_EQ(groups.count(), static_cast<std::size_t>(labels));
  std::vector<int> ours(truth.size(), -1);
  for (std::size_t g = 0; g < groups.count(); ++g)
    for (int i = groups.first[g]; i < groups.first[g + 1]; ++i) {
      const PixelRun& run = runs[groups.order[i]];
      ASSERT_LT(run.u_begin, run.u_end);
      int most_code = 0, as_bright_or_brighter = 0;
      for (int u = run.u_begin; u < run.u_end; ++u) {
        ours[run.v * luma.width_px + u] = static_cast<int>(g);
        most_code = std::max(most_code, luma.code(u, run.v));
        as_bright_or_brighter += luma.code(u, run.v) >= threshold + 1;
      }
      EXPECT_EQ(run.most_code, most_code);
      EXPECT_EQ(count_from(luma, run, threshold + 1), as_bright_or_brighter);
    }
  EXPECT_EQ(ours, truth);
}

class RunScan : public testing::TestWithParam<int> {};  // bit depth

TEST_P(RunScan, MatchesFloodFillOnRandomPlanes) {
  const int bit_depth = GetParam();
  Random random(11);
  for (const int width_px : {1, 2, 15, 63, 64, 65, 127, 128, 129, 191, 200, 333, 700}) {
    for (const double density : {0.005, 0.2, 0.45, 0.95}) {
      Plane plane(width_px, 23, bit_depth, 2 * (width_px % 3));
      const int full = (1 << bit_depth) - 1, threshold = full / 3;
      for (int v = 0; v < 23; ++v)
        for (int u = 0; u < width_px; ++u) {
          const bool bright = random.uniform() < density;
          // Ends of the ranges on purpose: threshold itself, one below it, 0 and the deepest code.
          const bool extreme = random.uniform() < 0.5;
          plane.set(u, v, bright ? (extreme ? threshold : full) : (extreme ? threshold - 1 : 0));
        }
      SCOPED_TRACE(testing::Message() << width_px << " wide, density " << density);
      expect_same_as_flood_fill(plane.view, threshold);
    }
  }
}

TEST_P(RunScan, ThresholdsBeyondTheCodes) {
  Plane plane(130, 2, GetParam());
  const int full = (1 << GetParam()) - 1;
  plane.set(129, 1, full);
  std::vector<PixelRun> runs{{7, 7, 7}};
  find_runs(plane.view, full, runs);
  ASSERT_EQ(runs.size(), 1u);
  EXPECT_EQ(runs[0].u_begin, 129);
  EXPECT_EQ(runs[0].v, 1);
  find_runs(plane.view, 1 << 16, runs);
  EXPECT_TRUE(runs.empty());
  find_runs(plane.view, -5, runs);  // counts as 1: zero is never bright
  EXPECT_EQ(runs.size(), 1u);
}

INSTANTIATE_TEST_SUITE_P(BitDepths, RunScan, testing::Values(8, 10, 12, 16));

TEST(RunScan, RowsWhoseMaximumIsKnownToBeDarkAreNotRead) {
  Plane plane(200, 3, 8);
  for (int v = 0; v < 3; ++v) plane.set(150, v, 90);
  const std::vector<std::uint8_t> maxima{90, 89, 255};
  plane.view.row_maxima = maxima.data();
  std::vector<PixelRun> runs;
  find_runs(plane.view, 90, runs);
  ASSERT_EQ(runs.size(), 2u);
  EXPECT_EQ(runs[0].v, 0);
  EXPECT_EQ(runs[1].v, 2);
  find_runs(plane.view, 91, runs);
  EXPECT_TRUE(runs.empty());  // one greater than the row's is no harm
}

TEST(RunGroups, EmptyListHasNoGroups) {
  RunGroups groups;
  group_runs({}, groups);
  EXPECT_EQ(groups.count(), 0u);
}

}  // namespace
}  // namespace vildar
