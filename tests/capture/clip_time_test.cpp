#include <algorithm>

#include "capture/clip_source.h"
#include "support/clip_writer.h"
#include "support/file_bytes.h"
#include "support/restamp.h"
#include "support/temporary_folder.h"

namespace vildar {
namespace {

using test::ClipSpec;
using test::restamp;

std::vector<double> times_of(ClipSource& source) {
  std::vector<double> times_s;
  while (const std::optional<Frame> frame = source.next())
    times_s.push_back(seconds_of(frame->time));
  return times_s;
}

bool warns_of(const ClipSource& source, const std::string& word) {
  return std::any_of(
      source.counts().warnings.begin(), source.counts().warnings.end(),
      [&](const std::string& warning) { return warning.find(word) != std::string::npos; });
}

TEST(ClipTime, VariableRateIsKeptAndStartsAtZero) {
  const TemporaryFolder folder;
  ClipSpec spec{.path = folder.path() / "vfr.mkv", .frames = 60};
  for (int k = 0; k < 60; ++k) spec.stamps_ms.push_back(5000 + 25 * k + (k * k * 7) % 19);
  write_clip(spec, test::index_painter());
  ClipSource source(spec.path);
  const std::vector<double> times_s = times_of(source);
  ASSERT_EQ(times_s.size(), 60U);
  for (std::size_t k = 0; k < 60; ++k)
    EXPECT_NEAR(times_s[k], static_cast<double>(spec.stamps_ms[k] - spec.stamps_ms[0]) * 1e-3,
                1e-9);
  EXPECT_EQ(source.counts().frames_dropped, 0);
  EXPECT_EQ(source.counts().time_stamps_repaired, 0);
}

TEST(ClipTime, FramesMissingFromASteadyRateAreCounted) {
  const TemporaryFolder folder;
  ClipSpec spec{.path = folder.path() / "gaps.mkv", .frames = 200};
  for (int k = 0, ms = 0; k < 200; ++k, ms += k == 30 ? 160 : k == 150 ? 80 : 40)
    spec.stamps_ms.push_back(ms);
  write_clip(spec, test::index_painter());
  ClipSource source(spec.path);
  times_of(source);
  EXPECT_EQ(source.counts().frames_dropped, 3 + 1);
}

TEST(ClipTime, AnOverrideReplacesEveryStamp) {
  const TemporaryFolder folder;
  ClipSpec spec{.path = folder.path() / "rate.mp4", .encoder = "mpeg4", .frames = 20};
  write_clip(spec, test::index_painter());
  ClipSource source(spec.path, {.frame_rate_hz = 240.0});
  EXPECT_TRUE(source.info().frame_rate_overridden);
  const std::vector<double> times_s = times_of(source);
  ASSERT_EQ(times_s.size(), 20U);
  for (std::size_t k = 0; k < 20; ++k)
    EXPECT_NEAR(times_s[k], static_cast<double>(k) / 240.0, 1e-9);
}

TEST(ClipTime, BackwardRepeatedAndWildStampsAreRepairedCountedAndTold) {
  const TemporaryFolder folder;
  ClipSpec spec{.path = folder.path() / "stamps.mkv", .width_px = 16, .height_px = 8, .frames = 30};
  spec.keyframe_interval = 1;
  for (int k = 0; k < 30; ++k) spec.stamps_ms.push_back(40 * k);
  write_clip(spec, test::index_painter());
  restamp(spec.path, 400, 100);    // backward
  restamp(spec.path, 600, 560);    // repeated
  restamp(spec.path, 800, 20000);  // far ahead, and the next one is back in place
  ClipSource source(spec.path);
  const std::vector<double> times_s = times_of(source);
  ASSERT_EQ(times_s.size(), 30U);
  for (std::size_t k = 0; k < 30; ++k)
    EXPECT_NEAR(times_s[k], 0.04 * static_cast<double>(k), 1e-9) << k;
  EXPECT_EQ(source.counts().time_stamps_repaired, 3);
  EXPECT_TRUE(warns_of(source, "3 time stamps"));
  EXPECT_TRUE(warns_of(source, "frame 10"));
  EXPECT_EQ(source.counts().frames_dropped, 0);
}

TEST(ClipTime, ARateThatTheStampsContradictIsTold) {
  const TemporaryFolder folder;
  ClipSpec spec{.path = folder.path() / "declared.mkv", .frames = 60, .rate_hz = 50};
  write_clip(spec, test::index_painter());
  {
    ClipSource source(spec.path);
    times_of(source);
    EXPECT_FALSE(warns_of(source, "declares"));
  }
  std::string bytes = test::bytes_of(spec.path);
  const std::size_t at = bytes.find("\x23\xe3\x83\x84");  // DefaultDuration, in nanoseconds
  ASSERT_NE(at, std::string::npos);
  const auto length = static_cast<std::size_t>(static_cast<unsigned char>(bytes[at + 3]) & 0x7f);
  for (std::size_t i = 0; i < length; ++i)
    bytes[at + 4 + i] = static_cast<char>(40'000'000 >> (8 * (length - 1 - i)));
  test::write_bytes(spec.path, bytes);
  ClipSource source(spec.path);
  EXPECT_NEAR(source.info().nominal_frame_rate_hz, 25.0, 0.01);
  const std::vector<double> times_s = times_of(source);
  EXPECT_NEAR(times_s.back(), 59 / 50.0, 1e-9);
  EXPECT_TRUE(warns_of(source, "declares 25.000"));
}

TEST(ClipTime, AFileWithoutStampsSaysSo) {
  const TemporaryFolder folder;
  ClipSpec spec{.path = folder.path() / "raw.h264", .encoder = "libx264", .frames = 20};
  write_clip(spec, test::index_painter());
  ClipSource source(spec.path);
  EXPECT_EQ(times_of(source).size(), 20U);
  EXPECT_TRUE(warns_of(source, "no time stamps"));
  ClipSource told(spec.path, {.frame_rate_hz = 25.0});
  EXPECT_EQ(times_of(told).size(), 20U);
  EXPECT_FALSE(warns_of(told, "no time stamps"));
}

}  // namespace
}  // namespace vildar
