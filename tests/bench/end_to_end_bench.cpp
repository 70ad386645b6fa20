// The whole of `vildar run` on a 1080p H.264 clip with up to four vehicles, against plain decoding
// of the same clip with libavcodec and the same number of threads, turn by turn in one run.
#include <ctime>
#include <filesystem>

#include <benchmark/benchmark.h>
extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

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

// Rendered once per process, removed at its end.
struct Clip {
  Clip() : folder(fs::temp_directory_path() / ("vildar_bench_" + std::to_string(::getpid()))) {
    render(load_scenario(fs::path(VILDAR_SOURCE_DIR) / "tests/bench/four_vehicles_1080p.yaml"),
           folder, {});
  }
  ~Clip() { fs::remove_all(folder); }
  fs::path folder;
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

void run_against_decoding(benchmark::State& state, bool fast) {
  static const Clip clip;
  RunOptions options;
  options.clip = clip.folder / "clip.mp4";
  options.site = clip.folder / "site.yaml";
  options.out = clip.folder / "out";
  options.clip_options.skip_loop_filter = fast;
  double decode_s = 0.0, run_s = 0.0;
  std::int64_t frames = 0;
  for (auto _ : state) {
    const double start_s = cpu_s();
    frames += decode_plainly(*options.clip);
    const double middle_s = cpu_s();
    benchmark::DoNotOptimize(run_pipeline(options));
    decode_s += middle_s - start_s;
    run_s += cpu_s() - middle_s;
  }
  state.counters["decode_ms_per_frame"] = 1e3 * decode_s / static_cast<double>(frames);
  state.counters["run_ms_per_frame"] = 1e3 * run_s / static_cast<double>(frames);
  state.counters["decode_over_run"] = decode_s / run_s;
}
BENCHMARK_CAPTURE(run_against_decoding, full, false)->Unit(benchmark::kSecond)->Iterations(5);
BENCHMARK_CAPTURE(run_against_decoding, fast, true)->Unit(benchmark::kSecond)->Iterations(5);

}  // namespace
}  // namespace vildar
