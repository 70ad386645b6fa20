#include <benchmark/benchmark.h>

#include "../estimate/delay_pass.h"
#include "../estimate/simulated_power.h"
#include "estimate/delay_light.h"
#include "estimate/recursive_fit.h"
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

// The same on a bend, where the vehicle's weave is unknown, too.
void estimate_pass_on_a_bend(benchmark::State& state) {
  Site site = simulated::mast_site(4.0);
  site.road.kind = RoadKind::curved;
  site.road.radius_m = Uncertain{60.0, 0.0};
  site.road.straight_m.mean = 5.0;
  site.camera->yaw_rad.mean = 0.25;
  const simulated::Vehicle vehicle{.speed_mps = 15.0, .along_m = 50.0, .weave = {.left_m = 0.08}};
  Random random(1);
  const VehicleTrack track = simulated::track_of(vehicle, site, {}, random);
  for (auto _ : state) benchmark::DoNotOptimize(estimate_vehicle(track, site, {}));
}
BENCHMARK(estimate_pass_on_a_bend)->Unit(benchmark::kMillisecond);

// One more frame of a vehicle that is being followed live.
void recursive_update(benchmark::State& state) {
  const Site site = simulated::mast_site(4.0);
  Random random(1);
  const VehicleTrack track = simulated::track_of({}, site, {.to_s = 2.2}, random);
  std::size_t next = track.sightings.size();
  std::optional<RecursiveFit> live;
  for (auto _ : state) {
    if (next == track.sightings.size()) {
      state.PauseTiming();
      live.emplace(site, track);
      for (next = 0; !live->state(); ++next) live->add(track.sightings[next]);
      state.ResumeTiming();
    }
    live->add(track.sightings[next++]);
  }
}
BENCHMARK(recursive_update)->Unit(benchmark::kMicrosecond);

// Two pulses of 3 s at 1 kHz.
void delay_of_two_photodiodes(benchmark::State& state) {
  const Site site = simulated::two_photodiodes(2.0);
  Random random(1);
  const simulated::Beam beam;
  const PowerTrace near = simulated::beam_trace({}, site, beam, 0, {}, random);
  const PowerTrace far = simulated::beam_trace({}, site, beam, 1, {}, random);
  const std::array<const PowerTrace*, 2> traces{&near, &far};
  for (auto _ : state) benchmark::DoNotOptimize(delay_speed(site, traces, 0.0, 8.0));
}
BENCHMARK(delay_of_two_photodiodes)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace vildar
