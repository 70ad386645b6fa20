#include "synth/render.h"

#include <cstring>
#include <fstream>
#include <memory>
#include <sstream>

#include <algorithm>

#include <gtest/gtest.h>
#include <sys/resource.h>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

#include "core/error.h"
#include "scenes.h"
#include "synth/clip_writer.h"
#include "synth/frame_times.h"
#include "synth/renderer.h"
#include "synth/truth.h"

// The leak checker asks for this by name: libx265 keeps a few bytes of its settings for good.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libx265\n"; }

namespace vildar {
namespace {

namespace fs = std::filesystem;

class Render : public ::testing::Test {
 protected:
  Render()
      : folder_(fs::path(::testing::TempDir()) /
                ("render_" +
                 std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()))) {
    fs::remove_all(folder_);
    scene_ = small_scene();
    scene_.vehicles = {car_at(40.0, 20.0)};
  }
  ~Render() override { fs::remove_all(folder_); }

  static std::string content(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
  }

  fs::path folder_;
  Scenario scene_;
};

/// Luma planes and time stamps of a clip, by libavcodec alone.
struct Decoded {
  int width_px = 0, height_px = 0;
  std::vector<std::string> luma, cr;
  std::vector<double> time_s;
  int range = 0;
};

Decoded decoded(const fs::path& file) {
  Decoded result;
  AVFormatContext* format = nullptr;
  EXPECT_EQ(avformat_open_input(&format, file.c_str(), nullptr, nullptr), 0);
  if (!format) return result;
  EXPECT_GE(avformat_find_stream_info(format, nullptr), 0);
  const AVStream* stream = format->streams[0];
  const AVCodec* codec = avcodec_find_decoder(stream->codecpar->codec_id);
  AVCodecContext* context = avcodec_alloc_context3(codec);
  avcodec_parameters_to_context(context, stream->codecpar);
  EXPECT_EQ(avcodec_open2(context, codec, nullptr), 0);
  AVPacket* packet = av_packet_alloc();
  AVFrame* frame = av_frame_alloc();
  const auto plane = [&](int index, int width, int height) {
    std::string bytes;
    for (int v = 0; v < height; ++v)
      bytes.append(reinterpret_cast<const char*>(frame->data[index] + v * frame->linesize[index]),
                   static_cast<std::size_t>(width));
    return bytes;
  };
  const auto drain = [&] {
    while (avcodec_receive_frame(context, frame) == 0) {
      result.width_px = frame->width;
      result.height_px = frame->height;
      result.range = frame->color_range;
      result.luma.push_back(plane(0, frame->width, frame->height));
      result.cr.push_back(plane(2, frame->width / 2, frame->height / 2));
      result.time_s.push_back(static_cast<double>(frame->pts) * av_q2d(stream->time_base));
    }
  };
  while (av_read_frame(format, packet) == 0) {
    avcodec_send_packet(context, packet);
    av_packet_unref(packet);
    drain();
  }
  avcodec_send_packet(context, nullptr);
  drain();
  av_frame_free(&frame);
  av_packet_free(&packet);
  avcodec_free_context(&context);
  avformat_close_input(&format);
  return result;
}

TEST_F(Render, ALosslessClipHoldsThePicturesBitForBit) {
  scene_.encoder.codec = ClipCodec::ffv1;
  render(scene_, folder_, {});
  const Decoded clip = decoded(folder_ / "clip.mkv");
  ASSERT_EQ(clip.luma.size(), 10u);
  EXPECT_EQ(clip.range, AVCOL_RANGE_MPEG);
  Renderer renderer(scene_);
  for (std::size_t i = 0; i < 10; ++i) {
    const Frame frame = renderer.image(static_cast<double>(i) / 25.0);
    EXPECT_EQ(std::memcmp(clip.luma[i].data(), frame.luma.data, 320 * 180), 0) << i;
    EXPECT_EQ(std::memcmp(clip.cr[i].data(), frame.chroma.cr, 160 * 90), 0) << i;
    EXPECT_NEAR(clip.time_s[i] - clip.time_s[0], static_cast<double>(i) / 25.0, 1e-3);
  }
}

TEST_F(Render, WritesTheFilesOfTheContractAndTheSameBytesAgain) {
  std::int64_t last = 0;
  const auto files = render(scene_, folder_ / "a", [&](std::int64_t done, std::int64_t total) {
    EXPECT_EQ(done, last + 1);
    EXPECT_EQ(total, 10);
    last = done;
  });
  EXPECT_EQ(last, 10);
  render(scene_, folder_ / "b", {});
  for (const char* name :
       {"clip.mp4", "photodiode.csv", "site.yaml", "truth_vehicles.csv", "truth_tracks.csv"}) {
    EXPECT_NE(std::find(files.begin(), files.end(), folder_ / "a" / name), files.end()) << name;
    const std::string bytes = content(folder_ / "a" / name);
    EXPECT_FALSE(bytes.empty()) << name;
    EXPECT_TRUE(bytes == content(folder_ / "b" / name)) << name;
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "a"), fs::directory_iterator()), 5)
      << "nothing half-written stays";
  const Decoded clip = decoded(folder_ / "a" / "clip.mp4");
  EXPECT_EQ(clip.luma.size(), 10u);
  EXPECT_EQ(clip.width_px, 320);
  EXPECT_NEAR(clip.time_s.at(9) - clip.time_s.at(0), 9.0 / 25.0, 1e-6);
}

TEST_F(Render, EveryCodecShowsTheSamePictures) {
  scene_.duration_s = 0.2;
  const Frame truth = Renderer(scene_).image(0.04);
  for (const ClipCodec codec : {ClipCodec::h265, ClipCodec::mjpeg}) {
    scene_.encoder.codec = codec;
    scene_.encoder.crf = 12;
    scene_.encoder.quality = 2;
    render(scene_, folder_, {});
    const Decoded clip = decoded(folder_ / clip_file_name(codec));
    ASSERT_EQ(clip.luma.size(), 5u);
    EXPECT_EQ(clip.range, AVCOL_RANGE_MPEG) << "or codes would mean another light";
    double off = 0.0;
    for (int i = 0; i < 320 * 180; ++i)
      off += std::abs(static_cast<std::uint8_t>(clip.luma[1][static_cast<std::size_t>(i)]) -
                      truth.luma.data[i]);
    EXPECT_LT(off / (320 * 180), 2.0) << clip_file_name(codec);
  }
}

TEST_F(Render, UnevenFramesKeepTheirTimesInTheClip) {
  scene_.duration_s = 1.0;
  scene_.frame_times = {0.004, 0.1, {7, 8}};
  const std::vector<double> times_s = frame_times_s(scene_);
  ASSERT_LT(times_s.size(), 24u);
  double spread_s = 0.0;
  for (const double time_s : times_s)
    spread_s = std::max(spread_s, std::abs(time_s * 25.0 - std::round(time_s * 25.0)) / 25.0);
  EXPECT_GT(spread_s, 0.002);
  for (const double time_s : times_s) {
    EXPECT_GT(std::abs(time_s - 7.0 / 25.0), 0.02);
    EXPECT_GT(std::abs(time_s - 8.0 / 25.0), 0.02);
  }
  for (const ClipCodec codec : {ClipCodec::h264, ClipCodec::ffv1}) {
    scene_.encoder.codec = codec;
    render(scene_, folder_, {});
    Decoded clip = decoded(folder_ / clip_file_name(codec));
    std::sort(clip.time_s.begin(), clip.time_s.end());
    ASSERT_EQ(clip.time_s.size(), times_s.size());
    for (std::size_t i = 0; i < times_s.size(); ++i)
      EXPECT_NEAR(clip.time_s[i] - clip.time_s[0], times_s[i], 1e-9);
  }
  const std::vector<TruthTrackRow> truth = truth_tracks(scene_);
  ASSERT_EQ(truth.size(), times_s.size());
  for (std::size_t i = 0; i < truth.size(); ++i) EXPECT_EQ(truth[i].time_s, times_s[i]);
}

TEST_F(Render, WritesTheToldSiteWhereThereIsOne) {
  scene_.site.camera.reset();
  Site told = scene_.site;
  told.channel->gain_db = Uncertain{-41.0, 2.0};
  scene_.told_site = told;
  render(scene_, folder_, {});
  EXPECT_NE(content(folder_ / "site.yaml").find("{mean: -41, std: 2}"), std::string::npos);
}

TEST_F(Render, WithoutACameraOnlyTheTrace) {
  scene_.site.camera.reset();
  render(scene_, folder_, {});
  EXPECT_FALSE(fs::exists(folder_ / "clip.mp4"));
  EXPECT_TRUE(fs::exists(folder_ / "photodiode.csv"));
}

// The largest memory that this process has held so far, in bytes.
long peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024L * usage.ru_maxrss;
}

TEST_F(Render, MemoryDoesNotGrowWithTheLength) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "the sanitizer holds freed memory back";
#endif
  CameraSite& camera = *scene_.site.camera;
  camera.width_px = 160;
  camera.height_px = 90;
  camera.principal_px = {79.5, 44.5};
  scene_.encoder.codec = ClipCodec::mjpeg;
  scene_.frame_rate_hz = 50.0;
  scene_.photodiode.rate_hz = 20'000.0;
  scene_.photodiode.noise_w = 1e-9;
  scene_.duration_s = 1.0;
  render(scene_, folder_, {});
  const long before = peak_memory();
  // Pictures alone are 4.1 MB, the trace 3.2 MB in numbers and 3.5 MB in letters.
  scene_.duration_s = 10.0;
  render(scene_, folder_, {});
  EXPECT_GT(fs::file_size(folder_ / "photodiode.csv"), 3'000'000u);
  EXPECT_LT(peak_memory() - before, 1'500'000) << "pictures or samples are kept";
}

TEST_F(Render, AFolderThatCannotBeMadeIsNamed) {
  fs::create_directories(folder_);
  std::ofstream(folder_ / "file") << "x";
  try {
    render(scene_, folder_ / "file" / "out", {});
    FAIL() << "no error";
  } catch (const OutputError& error) {
    EXPECT_NE(std::string(error.what()).find("file"), std::string::npos);
  }
}

}  // namespace
}  // namespace vildar
