#include "capture/row_maxima.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "capture/clip_source.h"
#include "core/random.h"
#include "support/clip_writer.h"
#include "support/file_bytes.h"
#include "support/temporary_folder.h"

namespace vildar {
namespace {

using test::ClipSpec;

/// Sharp edges on a changing ground: coding, prediction and the loop filter alter every row.
int restless(int frame, int u, int v) {
  const bool lit = (u + 3 * frame) % 37 < 5 && (v + frame) % 23 < 6;
  return lit ? 230 : 20 + (frame * 7919 + u * 104729 + v * 1299709) % 61;
}

int greatest_of(const LumaView& luma, int v) {
  int most = 0;
  for (int u = 0; u < luma.width_px; ++u) most = std::max(most, luma.code(u, v));
  return most;
}

struct Seen {
  int frames = 0, known = 0;
  bool exact = true;  ///< no maximum is greater than what the row shows
};

Seen look_through(const std::filesystem::path& path, const ClipOptions& options = {}) {
  Seen seen;
  ClipSource source(path, options);
  while (const std::optional<Frame> frame = source.next()) {
    ++seen.frames;
    const LumaView& luma = frame->luma;
    if (luma.row_maxima == nullptr) continue;
    ++seen.known;
    for (int v = 0; v < luma.height_px; ++v) {
      const int most = greatest_of(luma, v);
      EXPECT_GE(luma.row_maxima[v], most) << "frame " << frame->index << ", row " << v;
      seen.exact &= luma.row_maxima[v] == most;
    }
  }
  return seen;
}

TEST(RowMaxima, AreThoseOfEveryRowOfH264) {
  const TemporaryFolder folder;
  for (const char* settings :
       {"bframes=3:ref=4:weightp=2", "bframes=0:slices=3", "cabac=0:no-deblock=1",
        "constrained-intra=1:bframes=2:b-pyramid=2"}) {
    SCOPED_TRACE(settings);
    const ClipSpec spec{.path = folder.path() / "a.mp4",
                        .encoder = "libx264",
                        .width_px = 336,
                        .height_px = 160,
                        .frames = 24,
                        .encoder_options = {{"x264-params", settings}}};
    write_clip(spec, test::luma_painter(restless));
    for (const bool fast : {false, true}) {
      const Seen seen = look_through(spec.path, {.skip_loop_filter = fast});
      EXPECT_EQ(seen.frames, 24);
      EXPECT_EQ(seen.known, 24);
      EXPECT_TRUE(seen.exact);
    }
  }
}

// 37 x 50 is coded as 48 x 64.
TEST(RowMaxima, MayBeGreaterWhereLessIsShownThanIsCoded) {
  const TemporaryFolder folder;
  const ClipSpec spec{.path = folder.path() / "a.mp4",
                      .encoder = "libx264",
                      .pixel_format = "yuv444p",
                      .width_px = 37,
                      .height_px = 50};
  write_clip(spec, test::luma_painter(restless));
  EXPECT_EQ(look_through(spec.path).known, 30);
}

TEST(RowMaxima, AreNotKnownOfOtherDecodersDepthsAndThreads) {
  const TemporaryFolder folder;
  ClipSpec spec{.path = folder.path() / "a.mkv", .frames = 8};
  for (const auto& [encoder, format, threads] :
       {std::tuple("ffv1", "yuv420p", 1), std::tuple("mpeg4", "yuv420p", 1),
        std::tuple("libx264", "yuv420p10le", 1), std::tuple("libx264", "yuv420p", 2)}) {
    spec.encoder = encoder;
    spec.pixel_format = format;
    write_clip(spec, test::luma_painter(restless));
    const Seen seen = look_through(spec.path, {.decoder_threads = threads});
    EXPECT_EQ(seen.frames, 8) << encoder << ", " << format;
    EXPECT_EQ(seen.known, 0) << encoder << ", " << format;
  }
}

// The decoder mends what is missing, rows that it told of before as well.
TEST(RowMaxima, HoldInWhatDamageLeavesSound) {
  const TemporaryFolder folder;
  Random random(5);
  int known = 0;
  for (const char* name : {"a.mkv", "a.ts"}) {
    const ClipSpec spec{.path = folder.path() / name,
                        .encoder = "libx264",
                        .width_px = 160,
                        .height_px = 112,
                        .frames = 40,
                        .encoder_options = {{"x264-params", "slices=4:bframes=2"}}};
    write_clip(spec, test::luma_painter(restless));
    const std::string whole = test::bytes_of(spec.path);
    for (int trial = 0; trial < 20; ++trial) {
      std::string broken = whole;
      for (int flip = 0; flip < 3; ++flip)
        broken[static_cast<std::size_t>(random.uniform(0.2, 0.9) *
                                        static_cast<double>(broken.size()))] ^= 0x24;
      const auto path = folder.path() / ("broken" + spec.path.extension().string());
      test::write_bytes(path, broken);
      SCOPED_TRACE(testing::Message() << name << ", trial " << trial);
      known += look_through(path).known;
    }
  }
  EXPECT_GT(known, 400);  // of 1600, or nothing was tested
}

}  // namespace
}  // namespace vildar
