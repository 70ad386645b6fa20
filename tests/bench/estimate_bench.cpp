#include <benchmark/benchmark.h>

#include "../estimate/simulated_power.h"
#include "estimate/vehicle.h"

namespace vildar {
namespace {

// A pass of 2.5 s seen by a camera (76 frames, two lamps) and, asked for, a 1 kHz photodiode.
void estimate_pass_of_76_frames(benchmark::State& state) {
  Site site = simulated::mast_site(4.0);
  site.photodiodes.resize(1);
  site.photodiodes[0].position_m = site.camera->position_m;
  site.photodiodes[0].time_offset_s.std = 0.002;
  const simulated::Vehicle vehicle;
  Random random(1);
  const VehicleTrack track = simulated::track_of(vehicle, site, {}, random);
  const PowerTrace trace =
      simulated::trace_of(vehicle, site, {.noise_w = 1e-6, .time_offset_s = 0.001}, random);
  const VehiclePower power{&trace, false};
  const auto diodes = static_cast<std::size_t>(state.range(0));
  for (auto _ : state) benchmark::DoNotOptimize(estimate_vehicle(track, site, {&power, diodes}));
}
BENCHMARK(estimate_pass_of_76_frames)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace vildar
