#include "synth/render.h"

#include <cstring>
#include <fstream>
#include <memory>
#include <sstream>

#include <algorithm>

#include <gtest/gtest.h>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

#include "core/error.h"
#include "scenes.h"
#include "synth/renderer.h"

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

TEST_F(Render, WithoutACameraOnlyTheTrace) {
  scene_.site.camera.reset();
  render(scene_, folder_, {});
  EXPECT_FALSE(fs::exists(folder_ / "clip.mp4"));
  EXPECT_TRUE(fs::exists(folder_ / "photodiode.csv"));
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
