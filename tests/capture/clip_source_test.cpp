#include "capture/clip_source.h"

#include <stdexcept>

extern "C" {
#include <libavutil/frame.h>
}

#include <gtest/gtest.h>

#include "all_frames.h"
#include "support/clip_writer.h"
#include "support/temporary_folder.h"

namespace vildar {
namespace {

using test::ClipSpec;

int pattern(int frame, int u, int v) { return (7 * frame + 3 * u + 5 * v) % 256; }

void expect_pattern(const Frame& frame, int codes) {
  for (int v = 0; v < frame.luma.height_px; ++v)
    for (int u = 0; u < frame.luma.width_px; ++u)
      ASSERT_EQ(frame.luma.code(u, v), pattern(static_cast<int>(frame.index), u, v) * codes / 256)
          << "frame " << frame.index << " at " << u << ", " << v;
}

int index_shown(const Frame& frame) {
  int index = 0;
  for (int bit = 0; bit < 8; ++bit) {
    const int u = frame.luma.width_px / 8 * bit + frame.luma.width_px / 16;
    index |= (frame.luma.code(u, frame.luma.height_px / 2) > 125 ? 1 : 0) << bit;
  }
  return index;
}

TEST(ClipSource, LosslessLumaIsExactAndOutlivesTheSource) {
  const TemporaryFolder folder;
  ClipSpec spec{.path = folder.path() / "a.mkv", .width_px = 37, .height_px = 29, .frames = 12};
  write_clip(spec, test::luma_painter(pattern));
  std::vector<Frame> frames;
  {
    ClipSource source(spec.path);
    EXPECT_EQ(source.info().codec, "ffv1");
    EXPECT_TRUE(source.info().lossless);
    EXPECT_EQ(source.info().width_px, 37);
    EXPECT_EQ(source.info().height_px, 29);
    EXPECT_DOUBLE_EQ(source.info().nominal_frame_rate_hz, 25.0);
    frames = all_frames(source);
    EXPECT_FALSE(source.next());
    EXPECT_EQ(source.counts().frames_read, 12);
    EXPECT_FALSE(source.counts().damaged());
    EXPECT_TRUE(source.counts().warnings.empty());
  }
  ASSERT_EQ(frames.size(), 12U);
  for (const Frame& frame : frames) {
    expect_pattern(frame, 256);
    ASSERT_TRUE(frame.chroma.present());
    EXPECT_EQ(frame.chroma.cb_fraction(36, 28), 0.0);
  }
}

TEST(ClipSource, DeepAndGreyPicturesKeepTheirCodes) {
  const TemporaryFolder folder;
  for (const auto& [format, codes] :
       {std::pair("yuv420p10le", 1024), std::pair("gray", 256), std::pair("gray16le", 65536),
        std::pair("yuv444p12le", 4096)}) {
    ClipSpec spec{.path = folder.path() / (std::string(format) + ".mkv"),
                  .pixel_format = format,
                  .frames = 2};
    write_clip(spec, test::luma_painter([codes = codes](int frame, int u, int v) {
                 return pattern(frame, u, v) * codes / 256;
               }));
    ClipSource source(spec.path);
    EXPECT_EQ(1 << source.info().bit_depth, codes);
    const std::vector<Frame> frames = all_frames(source);
    ASSERT_EQ(frames.size(), 2U);
    expect_pattern(frames[1], codes);
    EXPECT_EQ(frames[1].chroma.present(), std::string_view(format).starts_with("yuv"));
  }
}

TEST(ClipSource, RangeComesFromTheClipAndAnAssumptionIsSaid) {
  const TemporaryFolder folder;
  struct Case {
    const char* encoder;
    const char* format;
    bool full, stated;
    const char* says;
    int black, white;
  };
  for (const Case& c : {Case{"ffv1", "yuv420p", false, true, "limited", 16, 235},
                        Case{"ffv1", "yuv420p", true, true, "full", 0, 255},
                        Case{"ffv1", "yuv420p", false, false, "limited (assumed)", 16, 235},
                        Case{"mjpeg", "yuvj420p", true, true, "full", 0, 255},
                        Case{"ffv1", "gray", false, false, "full (assumed)", 0, 255},
                        Case{"ffv1", "yuv420p10le", false, true, "limited", 64, 940}}) {
    ClipSpec spec{.path = folder.path() / "range.mkv",
                  .encoder = c.encoder,
                  .pixel_format = c.format,
                  .frames = 2};
    spec.full_range = c.full;
    spec.state_range = c.stated;
    write_clip(spec, test::index_painter());
    ClipSource source(spec.path);
    EXPECT_EQ(source.info().colour_range, c.says) << c.format;
    const Frame frame = source.next().value();
    EXPECT_EQ(frame.luma.black_code, c.black);
    EXPECT_EQ(frame.luma.white_code, c.white);
  }
}

TEST(ClipSource, SaysHowWideItsPixelsAre) {
  const TemporaryFolder folder;
  ClipSpec spec{.path = folder.path() / "aspect.mkv", .encoder = "ffv1", .frames = 2};
  write_clip(spec, test::index_painter());
  EXPECT_NEAR(ClipSource(spec.path).info().pixel_aspect.value_or(1.0), 1.0, 1e-9);
  spec.pixel_aspect = {4, 3};
  write_clip(spec, test::index_painter());
  EXPECT_NEAR(ClipSource(spec.path).info().pixel_aspect.value_or(1.0), 4.0 / 3.0, 1e-3);
}

TEST(ClipSource, GreyInRgbBecomesTheSameFullRangeLuma) {
  const TemporaryFolder folder;
  ClipSpec spec{.path = folder.path() / "rgb.mkv",
                .pixel_format = "bgr0",
                .width_px = 64,
                .height_px = 64,
                .frames = 4};
  const auto grey = [](int frame, int u, int v) { return (64 * frame + u + v) % 256; };
  write_clip(spec, [&](AVFrame& picture, int frame) {
    for (int v = 0; v < picture.height; ++v)
      for (int u = 0; u < picture.width; ++u)
        for (int component = 0; component < 4; ++component)
          picture.data[0][v * picture.linesize[0] + 4 * u + component] =
              static_cast<std::uint8_t>(grey(frame, u, v));
  });
  ClipSource source(spec.path);
  EXPECT_EQ(source.info().colour_range, "full");
  const std::vector<Frame> frames = all_frames(source);
  ASSERT_EQ(frames.size(), 4U);
  constexpr int kRounding = 1;
  for (int k = 0; k < 4; ++k)
    for (int v = 0; v < 64; ++v)
      for (int u = 0; u < 64; ++u)
        ASSERT_NEAR(frames[static_cast<std::size_t>(k)].luma.code(u, v), grey(k, u, v), kRounding);
}

TEST(ClipSource, LossyCodecsGiveEveryFrameInPresentationOrder) {
  const TemporaryFolder folder;
  struct Case {
    const char* encoder;
    const char* format;
    const char* file;
  };
  for (const Case& c : {Case{"libx264", "yuv420p", "a.mp4"}, Case{"libx264", "yuv420p", "a.ts"},
                        Case{"mpeg4", "yuv420p", "a.avi"}, Case{"mjpeg", "yuvj420p", "a.mov"}}) {
    ClipSpec spec{.path = folder.path() / c.file,
                  .encoder = c.encoder,
                  .pixel_format = c.format,
                  .frames = 70};
    write_clip(spec, test::index_painter());
    for (const int threads : {1, 3}) {
      ClipSource source(spec.path, {.decoder_threads = threads});
      const std::vector<Frame> frames = all_frames(source);
      ASSERT_EQ(frames.size(), 70U) << c.file;
      for (int k = 0; k < 70; ++k) {
        const Frame& frame = frames[static_cast<std::size_t>(k)];
        EXPECT_EQ(index_shown(frame), k);
        EXPECT_EQ(frame.index, k);
        EXPECT_NEAR(seconds_of(frame.time), k / 25.0, 2e-5) << c.file;  // 90 kHz stamps at worst
        EXPECT_FALSE(frame.damaged);
      }
      EXPECT_FALSE(source.counts().damaged()) << c.file;
      EXPECT_EQ(source.counts().frames_dropped, 0) << c.file;
    }
  }
}

TEST(ClipSource, RotationIsToldAndPixelsStayAsStored) {
  const TemporaryFolder folder;
  for (const int turn_deg : {90, 180, 270}) {
    ClipSpec spec{.path = folder.path() / "turned.mp4", .encoder = "libx264", .frames = 3};
    spec.rotate_clockwise_deg = turn_deg;
    write_clip(spec, test::index_painter());
    ClipSource source(spec.path);
    EXPECT_EQ(source.info().rotation_deg, turn_deg);
    EXPECT_EQ(source.info().width_px, turn_deg == 180 ? 64 : 48);
    EXPECT_EQ(source.info().height_px, turn_deg == 180 ? 48 : 64);
    const Frame frame = source.next().value();
    EXPECT_EQ(frame.rotation_deg, turn_deg);
    EXPECT_EQ(frame.luma.width_px, 64);
  }
}

TEST(ClipSource, LoopFilterIsSkippedForH264Only) {
  const TemporaryFolder folder;
  for (const auto& [encoder, differs] : {std::pair("libx264", true), std::pair("mpeg4", false)}) {
    ClipSpec spec{.path = folder.path() / "filter.mkv", .encoder = encoder, .frames = 6};
    if (differs) spec.encoder_options = {{"crf", "38"}};
    write_clip(spec, test::luma_painter([](int frame, int u, int v) {
                 return 16 + (frame * u * 3 + v * v) % 200;
               }));
    ClipSource plain(spec.path);
    ClipSource skipping(spec.path, {.skip_loop_filter = true});
    int changed = 0;
    for (int k = 0; k < 6; ++k) {
      const Frame a = plain.next().value(), b = skipping.next().value();
      for (int v = 0; v < a.luma.height_px; ++v)
        for (int u = 0; u < a.luma.width_px; ++u) changed += a.luma.code(u, v) != b.luma.code(u, v);
    }
    EXPECT_EQ(changed > 0, differs) << encoder;
  }
}

TEST(ClipSource, ExtremeSizesAreRead) {
  const TemporaryFolder folder;
  for (const auto& [width, height] : {std::pair(1, 1), std::pair(16384, 2), std::pair(1, 2000)}) {
    ClipSpec spec{.path = folder.path() / "size.mkv",
                  .pixel_format = "gray",
                  .width_px = width,
                  .height_px = height,
                  .frames = 2};
    write_clip(spec, test::luma_painter(pattern));
    ClipSource source(spec.path);
    const std::vector<Frame> frames = all_frames(source);
    ASSERT_EQ(frames.size(), 2U);
    expect_pattern(frames[1], 256);
  }
}

TEST(ClipSource, OptionsOutOfRangeAreNamed) {
  const ClipOptions options{.frame_rate_hz = 0.0, .decoder_threads = 0};
  EXPECT_EQ(options.problems().size(), 2U);
  EXPECT_TRUE(ClipOptions{}.problems().empty());
  EXPECT_THROW(ClipSource("any.mp4", options), std::invalid_argument);
}

TEST(ClipSource, ReadsTheFirstFieldOfInterlacedPictures) {
  const TemporaryFolder folder;
  for (const bool top_first : {true, false}) {
    const ClipSpec spec{.path = folder.path() / "a.mp4",
                        .encoder = "libx264",
                        .width_px = 64,
                        .height_px = 64,
                        .frames = 3,
                        .encoder_options = {{"x264-params", "tff=1:qp=0"}}};
    const int first = top_first ? 0 : 1;  // row of the field taken first
    const test::Painter paint =
        test::luma_painter([first](int, int, int v) { return v % 2 == first ? 60 + 2 * v : 210; });
    write_clip(spec, [&](AVFrame& picture, int frame) {
      picture.top_field_first = top_first ? 1 : 0;
      paint(picture, frame);
    });
    ClipSource source(spec.path, {});
    const std::vector<Frame> frames = all_frames(source);
    ASSERT_EQ(frames.size(), 3U);
    for (const Frame& frame : frames) {
      EXPECT_EQ(frame.luma.row_maxima, nullptr) << "of both fields";
      for (int v = 1; v < 63; ++v) EXPECT_EQ(frame.luma.code(20, v), 60 + 2 * v) << "row " << v;
    }
    ASSERT_FALSE(source.counts().warnings.empty());
    EXPECT_NE(source.counts().warnings.back().find("interlaced"), std::string::npos);
  }
}

}  // namespace
}  // namespace vildar
