#include <algorithm>

#include <gtest/gtest.h>

#include "all_frames.h"
#include "capture/clip_source.h"
#include "core/error.h"
#include "core/random.h"
#include "support/clip_writer.h"
#include "support/file_bytes.h"
#include "support/temporary_folder.h"

namespace vildar {
namespace {

using test::ClipSpec;

std::string error_of(const std::filesystem::path& path) {
  try {
    ClipSource source(path);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

void expect_refused(const std::filesystem::path& path, const std::string& fault) {
  const std::string error = error_of(path);
  EXPECT_NE(error.find(path.string()), std::string::npos) << error;
  EXPECT_NE(error.find(fault), std::string::npos) << error;
  EXPECT_NE(error.find(';'), std::string::npos) << "names no remedy: " << error;
}

/// Noise that makes packets large, so that cuts and flips land in picture data.
int noise(int frame, int u, int v) {
  return 40 +
         static_cast<int>(
             (static_cast<unsigned>(frame * 7919 + u * 104729 + v * 1299709) * 2654435761U) >> 26);
}

ClipSpec noisy_clip(const std::filesystem::path& path, const char* encoder) {
  ClipSpec spec{.path = path, .encoder = encoder, .width_px = 96, .height_px = 80, .frames = 50};
  if (spec.encoder == "ffv1") spec.encoder_options = {{"level", "3"}, {"slicecrc", "1"}};
  if (spec.encoder == "mjpeg") spec.pixel_format = "yuvj420p";
  if (spec.path.extension() == ".mp4") spec.muxer_options = {{"movflags", "+faststart"}};
  write_clip(spec, test::luma_painter(noise));
  return spec;
}

TEST(ClipDamage, WhatIsNoClipIsRefusedWithFileFaultAndRemedy) {
  const TemporaryFolder folder;
  expect_refused(folder.path() / "missing.mp4", "no such file");
  std::filesystem::create_directory(folder.path() / "folder.mp4");
  expect_refused(folder.path() / "folder.mp4", "is a folder");
  test::write_bytes(folder.path() / "empty.mp4", "");
  expect_refused(folder.path() / "empty.mp4", "empty");
  std::string prose;
  for (int i = 0; i < 200; ++i) prose += "The lamps of a car at night, as seen from a bridge.\n";
  for (const char* name : {"text.mp4", "text.txt", "text.avi"}) {
    test::write_bytes(folder.path() / name, prose);
    expect_refused(folder.path() / name, "");
  }
  std::string wav =
      "RIFF\x24\x10\0\0WAVEfmt "
      "\x10\0\0\0\x01\0\x01\0\x40\x1f\0\0\x80\x3e\0\0\x02\0\x10\0data\0\x10\0\0";
  wav = std::string(
            "RIFF\x24\x10\0\0WAVEfmt \x10\0\0\0\x01\0\x01\0\x40\x1f\0\0\x80\x3e\0\0\x02\0\x10\0"
            "data\0\x10\0\0",
            44) +
        std::string(4096, '\x11');
  test::write_bytes(folder.path() / "sound.wav", wav);
  expect_refused(folder.path() / "sound.wav", "only sound");
}

TEST(ClipDamage, RandomBytesNeverCrash) {
  const TemporaryFolder folder;
  Random random(7);
  for (int trial = 0; trial < 20; ++trial) {
    std::string bytes(3000, ' ');
    for (char& byte : bytes) byte = static_cast<char>(random.uniform(0.0, 256.0));
    test::write_bytes(folder.path() / "random.mp4", bytes);
    EXPECT_NE(error_of(folder.path() / "random.mp4"), "no error");
  }
}

TEST(ClipDamage, AnMp4WithoutItsIndexIsRefused) {
  const TemporaryFolder folder;
  ClipSpec spec{.path = folder.path() / "cut.mp4", .encoder = "libx264"};
  write_clip(spec, test::luma_painter(noise));
  std::filesystem::resize_file(spec.path, std::filesystem::file_size(spec.path) / 2);
  expect_refused(spec.path, "moov");
}

TEST(ClipDamage, AMatroskaWithoutItsFramesIsRefused) {
  const TemporaryFolder folder;
  const ClipSpec spec = noisy_clip(folder.path() / "header.mkv", "libx264");
  const std::string bytes = test::bytes_of(spec.path);
  test::write_bytes(spec.path, bytes.substr(0, bytes.find("\x1f\x43\xb6\x75")));
  expect_refused(spec.path, "ends before its first frame");
}

TEST(ClipDamage, TruncatedClipsAreUsedAsFarAsTheyGo) {
  const TemporaryFolder folder;
  for (const auto& [name, encoder] :
       {std::pair("cut.mp4", "libx264"), std::pair("cut.mkv", "libx264"),
        std::pair("cut.avi", "mjpeg"), std::pair("cut.mkv", "ffv1")}) {
    const ClipSpec spec = noisy_clip(folder.path() / name, encoder);
    std::filesystem::resize_file(spec.path, std::filesystem::file_size(spec.path) * 6 / 10);
    ClipSource source(spec.path);
    const auto read = static_cast<double>(all_frames(source).size());
    EXPECT_GT(read, 20.0) << name;
    EXPECT_LT(read, 40.0) << name;
    EXPECT_TRUE(source.counts().truncated) << name;
    EXPECT_TRUE(source.counts().damaged());
    ASSERT_FALSE(source.counts().warnings.empty());
    EXPECT_NE(source.counts().warnings.back().find("ends early"), std::string::npos);
  }
}

// It has no index, and its frames one size.
TEST(ClipDamage, AnUncompressedClipThatEndsWithinAFrameIsTruncated) {
  const TemporaryFolder folder;
  constexpr std::size_t kFrames = 20, kFrame_bytes = 96 * 80 * 3 / 2;
  std::string bytes = "YUV4MPEG2 W96 H80 F25:1 Ip A1:1 C420jpeg\n";
  for (std::size_t frame = 0; frame < kFrames; ++frame)
    bytes += "FRAME\n" + std::string(kFrame_bytes, static_cast<char>(60 + frame));
  for (const auto& [cut_bytes, truncated] : {std::pair<std::size_t, bool>{0, false},
                                             {kFrame_bytes / 2, true},
                                             {kFrame_bytes, true},
                                             {kFrame_bytes + 3, true},
                                             {kFrame_bytes + 6, false}}) {
    const auto path = folder.path() / "cut.y4m";
    test::write_bytes(path, bytes.substr(0, bytes.size() - cut_bytes));
    ClipSource source(path);
    EXPECT_EQ(all_frames(source).size(), cut_bytes == 0 ? kFrames : kFrames - 1) << cut_bytes;
    EXPECT_EQ(source.counts().truncated, truncated) << cut_bytes;
  }
}

TEST(ClipDamage, WholeClipsAreNotCalledTruncated) {
  const TemporaryFolder folder;
  for (const char* name : {"whole.mp4", "whole.mkv", "whole.avi", "whole.ts"}) {
    const ClipSpec spec = noisy_clip(folder.path() / name, "mpeg4");
    ClipSource source(spec.path);
    EXPECT_EQ(all_frames(source).size(), 50U) << name;
    EXPECT_FALSE(source.counts().damaged()) << name;
    EXPECT_TRUE(source.counts().warnings.empty())
        << name << ": " << source.counts().warnings.front();
  }
}

// As a recorder that cuts a long recording into files leaves them.
TEST(ClipDamage, AClipWhoseStampsBeginLateIsWhole) {
  const TemporaryFolder folder;
  ClipSpec spec{.path = folder.path() / "late.mkv", .encoder = "mpeg4", .frames = 50};
  for (int frame = 0; frame < spec.frames; ++frame) spec.stamps_ms.push_back(30'000 + 40 * frame);
  write_clip(spec, test::luma_painter(noise));
  ClipSource source(spec.path);
  EXPECT_EQ(all_frames(source).size(), 50U);
  EXPECT_FALSE(source.counts().truncated);
}

TEST(ClipDamage, FlippedBitsInTheMiddleAreSurvivedCountedAndNotPrinted) {
  const TemporaryFolder folder;
  for (const char* encoder : {"libx264", "mpeg4", "ffv1"}) {
    for (const int threads : {1, 3}) {
      const ClipSpec spec = noisy_clip(folder.path() / "flipped.mkv", encoder);
      std::string bytes = test::bytes_of(spec.path);
      Random random(11);
      for (int flip = 0; flip < 60; ++flip)
        bytes[static_cast<std::size_t>(random.uniform(0.45, 0.55) *
                                       static_cast<double>(bytes.size()))] ^= 0x15;
      test::write_bytes(spec.path, bytes);
      ::testing::internal::CaptureStderr();
      ClipSource source(spec.path, {.decoder_threads = threads});
      const std::vector<Frame> frames = all_frames(source);
      EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
      EXPECT_GT(frames.size(), 38U) << encoder;
      EXPECT_TRUE(source.counts().damaged()) << encoder;
      EXPECT_GT(source.counts().packets_damaged, 0) << encoder;
      EXPECT_GT(source.counts().frames_damaged, 0) << encoder;
      EXPECT_FALSE(source.counts().truncated) << encoder;
      const auto flagged = std::count_if(frames.begin(), frames.end(),
                                         [](const Frame& frame) { return frame.damaged; });
      EXPECT_EQ(flagged, source.counts().frames_damaged + source.counts().frames_after_damage);
      EXPECT_GT(source.counts().frames_after_damage, 0) << encoder;
      EXPECT_FALSE(frames.front().damaged);
      EXPECT_FALSE(frames.back().damaged)
          << encoder << ": damage must not spread past the next keyframe";
    }
  }
}

TEST(ClipDamage, FramesOfAnotherSizeAreLeftOutAndCounted) {
  const TemporaryFolder folder;
  ClipSpec small{.path = folder.path() / "small.mjpeg",
                 .encoder = "mjpeg",
                 .pixel_format = "yuvj420p",
                 .frames = 6};
  ClipSpec large = small;
  large.path = folder.path() / "large.mjpeg";
  large.width_px = 128;
  large.frames = 4;
  write_clip(small, test::index_painter());
  write_clip(large, test::index_painter());
  test::write_bytes(
      folder.path() / "both.mjpeg",
      test::bytes_of(small.path) + test::bytes_of(large.path) + test::bytes_of(small.path));
  ClipSource source(folder.path() / "both.mjpeg");
  const std::vector<Frame> frames = all_frames(source);
  ASSERT_EQ(frames.size(), 12U);
  for (const Frame& frame : frames) EXPECT_EQ(frame.luma.width_px, 64);
  EXPECT_EQ(frames[6].index, 10) << "left-out frames keep their place in the count";
  EXPECT_EQ(source.counts().frames_of_other_size, 4);
  EXPECT_EQ(source.counts().frames_read, 16);
}

}  // namespace
}  // namespace vildar
