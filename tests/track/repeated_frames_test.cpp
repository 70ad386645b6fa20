#include "track/repeated_frames.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "core/clock.h"

namespace vildar {
namespace {

void add_light(BlobFrame& frame, const Eigen::Vector2d& at_px, double sigma_px, int wide_px) {
  Blob blob;
  blob.centre_px = at_px;
  blob.centre_sigma_px = {sigma_px, sigma_px};
  blob.area_px = wide_px * wide_px;
  blob.flux = wide_px * wide_px;
  const auto u = static_cast<int>(at_px.x()), v = static_cast<int>(at_px.y());
  blob.box = {u, v, u + wide_px, v + wide_px};
  frame.blobs.push_back(blob);
}

// A lit road as a coder leaves it: stains that stand to the last code, one of which has jumped.
// Far fewer are the tail lamps that drive away, at first by more than their own width from frame to
// frame.
int left_out(bool drives) {
  constexpr int kFrames = 60, kStains = 40, kJumps = 3, kStops = 9;
  RepeatedFrames repeated;
  int count = 0;
  for (int i = 0; i < kFrames; ++i) {
    BlobFrame frame;
    frame.time = time_from_seconds<CameraTime>(i / 30.0);
    for (int k = 0; k < kStains; ++k) {
      Eigen::Vector2d at_px(100.0 + 120.0 * (k % 10), 450.0 + 80.0 * (k / 10));
      if (k == 0 && i >= kJumps) at_px += Eigen::Vector2d(-20.0, 10.0);
      add_light(frame, at_px, 1.0, 24);
    }
    const double down_px = drives ? 300.0 * 5.0 / (5.0 + i) : 300.0 - 6.0 * std::min(i, kStops);
    for (const double side : {-0.3, 0.3})
      add_light(frame, {640.0 + side * down_px, 360.0 + down_px}, 0.15, 5);
    count += repeated.repeats(frame);
  }
  return count;
}

TEST(RepeatedFrames, ALampThatDrivesOnAmongStainsOfTheRoadTellsThatNoneIs) {
  EXPECT_EQ(left_out(true), 0);
}

TEST(RepeatedFrames, WhereItStandsAllAtOnceAllAre) { EXPECT_EQ(left_out(false), 50); }

}  // namespace
}  // namespace vildar
