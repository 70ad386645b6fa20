#include <benchmark/benchmark.h>

#include "../track/scene.h"

namespace vildar {
namespace {

// One update with the given number of vehicles in two lanes, as a roadside camera sees them.
void BM_TrackFrame(benchmark::State& state) {
  scene::Scene made;
  made.site = scene::site_of(8.0, -6.0, 1400.0, 1920, 1080);
  for (int i = 0; i < state.range(0); ++i) {
    scene::Car car;
    car.x_m = 40.0 + 8.0 * (i / 2);
    car.y_m = i % 2 ? -4.0 : -7.5;
    car.speed_mps = -2.0;
    made.cars.push_back(car);
  }
  const Camera camera(*made.site.camera);
  std::vector<BlobFrame> frames;
  for (int k = 0; k < 150; ++k) {
    BlobFrame frame;
    frame.frame = k;
    frame.time = time_from_seconds<CameraTime>(0.04 * k);
    for (const scene::Light& light : scene::lights_at(made, camera, 0.04 * k)) {
      Blob blob;
      blob.centre_px = light.at_px;
      blob.flux = light.flux;
      blob.kind = light.kind;
      frame.blobs.push_back(blob);
    }
    frames.push_back(frame);
  }
  std::int64_t updates = 0;
  for (auto _ : state) {
    Tracker tracker({}, made.site);
    for (BlobFrame frame : frames) benchmark::DoNotOptimize(tracker.update(frame));
    updates += static_cast<std::int64_t>(frames.size());
  }
  state.counters["per_frame"] = benchmark::Counter(
      static_cast<double>(updates), benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(BM_TrackFrame)->Arg(1)->Arg(4)->Arg(20)->Arg(100)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace vildar
