#include <benchmark/benchmark.h>

#include "synth/renderer.h"

namespace vildar {
namespace {

// Four cars between 20 and 80 m before a 1280x720 camera on a 5 m mast; pictures only, no encoding.
void BM_RenderImage720p(benchmark::State& state) {
  Scenario scenario;
  scenario.duration_s = 1.0;
  CameraSite camera;
  camera.width_px = 1280;
  camera.height_px = 720;
  camera.focal_px = {1000.0, 1000.0};
  camera.principal_px = {639.5, 359.5};
  camera.position_m[2].mean = 5.0;
  camera.pitch_rad.mean = -0.1;
  camera.exposure_s = 0.001;
  camera.rolling_shutter_s = 0.02;
  scenario.site.camera = camera;
  scenario.site.road.lanes.push_back({"near", {-3.0, 0.0}, 3.5, Direction::oncoming});
  for (int i = 0; i < 4; ++i) {
    VehicleScene vehicle;
    vehicle.id = std::to_string(i);
    vehicle.speed_mps = 15.0;
    vehicle.along_at_zero_m = 20.0 + 20.0 * i;
    scenario.vehicles.push_back(vehicle);
  }
  scenario.wet_road = state.range(0) != 0;
  Renderer renderer(scenario);
  double time_s = 0.0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(renderer.image(time_s).luma.data);
    time_s = time_s < 0.3 ? time_s + 0.04 : 0.0;
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(BM_RenderImage720p)->ArgName("wet")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace vildar
