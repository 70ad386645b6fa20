// The whole of `vildar run` on rendered clips, against plain decoding of the same clip with
// libavcodec and the same number of threads, and where OpenCV's videoio is at hand against the
// plainest loop that finds bright spots with it, turn by turn in one run.
#include <ctime>
#include <filesystem>

#include <benchmark/benchmark.h>
extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}
#ifdef VILDAR_OPENCV_VIDEOIO
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#endif

#include "pipelines/run_pipeline.h"
#include "synth/render.h"
#include "synth/scenario.h"

namespace vildar {
namespace {

namespace fs = std::filesystem;

double cpu_s() {
  timespec now{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Kind {
  int vehicles = 2;         // two lamps each
  double brightness = 1.0;  // of all lamps; 1: they clip
  double size = 1.0;        // of 1920 x 1080
  ClipCodec codec = ClipCodec::h264;
};

Scenario scenario_of(const Kind& kind) {
  Scenario scenario =
      load_scenario(fs::path(VILDAR_SOURCE_DIR) / "tests/bench/four_vehicles_1080p.yaml");
  const std::size_t given = scenario.vehicles.size(),
                    wanted = static_cast<std::size_t>(kind.vehicles);
  for (std::size_t i = given; i < wanted; ++i) {
    VehicleScene behind = scenario.vehicles[i - given];
    behind.id += "2";
    behind.along_at_zero_m += 22.0;
    scenario.vehicles.push_back(behind);
  }
  scenario.vehicles.resize(wanted);
  for (VehicleScene& vehicle : scenario.vehicles) vehicle.intensity_cd *= kind.brightness;
  CameraSite& camera = *scenario.site.camera;
  camera.width_px = static_cast<int>(camera.width_px * kind.size);
  camera.height_px = static_cast<int>(camera.height_px * kind.size);
  for (double& focal_px : camera.focal_px) focal_px *= kind.size;
  for (double& middle_px : camera.principal_px) middle_px = (middle_px + 0.5) * kind.size - 0.5;
  scenario.encoder.codec = kind.codec;
  scenario.encoder.bitrate_bps = static_cast<int>(7e6 * kind.size * kind.size);
  if (kind.codec == ClipCodec::mjpeg) scenario.encoder.bitrate_bps.reset();
  return scenario;
}

// Removed when the benchmark ends.
struct Clip {
  explicit Clip(const Kind& kind)
      : folder(fs::temp_directory_path() / ("vildar_bench_" + std::to_string(::getpid()))) {
    const Scenario scenario = scenario_of(kind);
    render(scenario, folder, {});
    for (const auto& entry : fs::directory_iterator(folder))
      if (entry.path().stem() == "clip") file = entry.path();
  }
  ~Clip() { fs::remove_all(folder); }
  fs::path folder, file;
};

std::int64_t decode_plainly(const fs::path& file) {
  AVFormatContext* container = nullptr;
  if (avformat_open_input(&container, file.c_str(), nullptr, nullptr) < 0) return 0;
  avformat_find_stream_info(container, nullptr);
  const AVCodec* codec = nullptr;
  const int stream = av_find_best_stream(container, AVMEDIA_TYPE_VIDEO, -1, -1, &codec, 0);
  AVCodecContext* decoder = avcodec_alloc_context3(codec);
  avcodec_parameters_to_context(decoder, container->streams[stream]->codecpar);
  decoder->thread_count = 1;
  avcodec_open2(decoder, codec, nullptr);
  AVPacket* packet = av_packet_alloc();
  AVFrame* frame = av_frame_alloc();
  std::int64_t frames = 0;
  const auto drain = [&] {
    while (avcodec_receive_frame(decoder, frame) == 0) ++frames;
  };
  while (av_read_frame(container, packet) >= 0) {
    if (packet->stream_index == stream && avcodec_send_packet(decoder, packet) == 0) drain();
    av_packet_unref(packet);
  }
  avcodec_send_packet(decoder, nullptr);
  drain();
  av_frame_free(&frame);
  av_packet_free(&packet);
  avcodec_free_context(&decoder);
  avformat_close_input(&container);
  return frames;
}

#ifdef VILDAR_OPENCV_VIDEOIO
void find_spots_plainly(const fs::path& file) {
  constexpr double kBright = 200.0;
  cv::setNumThreads(1);
  ::setenv("OPENCV_FFMPEG_CAPTURE_OPTIONS", "threads;1", 1);
  cv::VideoCapture capture(file.string(), cv::CAP_FFMPEG);
  cv::Mat picture, grey, bright;
  std::vector<std::vector<cv::Point>> outlines;
  while (capture.read(picture)) {
    cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
    cv::threshold(grey, bright, kBright, 255.0, cv::THRESH_BINARY);
    cv::findContours(bright, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
    benchmark::DoNotOptimize(outlines.size());
  }
}
#endif

void run_against_decoding(benchmark::State& state, Kind kind, bool fast) {
  const Clip clip(kind);
  RunOptions options;
  options.clip = clip.file;
  options.site = clip.folder / "site.yaml";
  options.out = clip.folder / "out";
  options.clip_options.skip_loop_filter = fast;
  double decode_s = 0.0, run_s = 0.0;
  [[maybe_unused]] double opencv_s = 0.0;
  std::int64_t frames = 0;
  for (auto _ : state) {
    const double start_s = cpu_s();
    frames += decode_plainly(*options.clip);
    const double middle_s = cpu_s();
    benchmark::DoNotOptimize(run_pipeline(options));
    decode_s += middle_s - start_s;
    run_s += cpu_s() - middle_s;
#ifdef VILDAR_OPENCV_VIDEOIO
    const double run_end_s = cpu_s();
    find_spots_plainly(*options.clip);
    opencv_s += cpu_s() - run_end_s;
#endif
  }
  state.counters["decode_ms_per_frame"] = 1e3 * decode_s / static_cast<double>(frames);
  state.counters["run_ms_per_frame"] = 1e3 * run_s / static_cast<double>(frames);
  state.counters["decode_over_run"] = decode_s / run_s;
#ifdef VILDAR_OPENCV_VIDEOIO
  state.counters["opencv_ms_per_frame"] = 1e3 * opencv_s / static_cast<double>(frames);
  state.counters["decode_over_opencv"] = decode_s / opencv_s;
#endif
}
#define VILDAR_RUN(name, ...)                                \
  BENCHMARK_CAPTURE(run_against_decoding, name, __VA_ARGS__) \
      ->Unit(benchmark::kSecond)                             \
      ->Iterations(5)
VILDAR_RUN(lamps_4, Kind{}, false);
VILDAR_RUN(lamps_4_fast, Kind{}, true);
VILDAR_RUN(lamps_12_unclipped, (Kind{6, 0.002}), false);
VILDAR_RUN(lamps_12_clipped, (Kind{6}), false);
VILDAR_RUN(lamps_12_clipped_fast, (Kind{6}), true);
VILDAR_RUN(size_720p, (Kind{2, 1.0, 2.0 / 3.0}), false);
VILDAR_RUN(size_4k, (Kind{2, 1.0, 2.0}), false);
VILDAR_RUN(hevc, (Kind{2, 1.0, 1.0, ClipCodec::h265}), false);
VILDAR_RUN(mjpeg, (Kind{2, 1.0, 1.0, ClipCodec::mjpeg}), false);

}  // namespace
}  // namespace vildar
