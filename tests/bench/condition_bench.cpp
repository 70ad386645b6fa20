#include <benchmark/benchmark.h>

#include <cmath>

#include "condition/condition.h"
#include "core/quantity.h"
#include "core/random.h"

namespace vildar {
namespace {

/// Ten minutes with a car every 20 s; mains flicker of the given amplitude, and dusk.
PhotodiodeRecording recording(double rate_hz, double flicker_w, double dusk_w) {
  PhotodiodeRecording recording;
  recording.ids = {""};
  recording.values.resize(1);
  Random random(1);
  const auto samples = static_cast<std::size_t>(600.0 * rate_hz);
  for (std::size_t k = 0; k < samples; ++k) {
    const double time_s = static_cast<double>(k) / rate_hz;
    const double before_m = 15.0 * (10.0 - std::fmod(time_s, 20.0));
    const double light_w = 2e-8 + dusk_w * std::exp(-time_s / 200.0) +
                           (before_m > 0.0 ? 5e-6 / (before_m * before_m + 30.0) : 0.0) +
                           flicker_w * std::sin(2.0 * kPi * 100.1 * time_s) +
                           random.normal(0.0, 3e-10);
    recording.time_s.push_back(time_s);
    recording.values[0].push_back(static_cast<float>(light_w));
  }
  return recording;
}

void condition_trace(benchmark::State& state, double rate_hz, double flicker_w, double dusk_w) {
  const PhotodiodeRecording input = recording(rate_hz, flicker_w, dusk_w);
  Site site;
  site.photodiodes.emplace_back().id = "pd0";
  for (auto _ : state) {
    state.PauseTiming();
    PhotodiodeRecording moved = input;
    state.ResumeTiming();
    const std::vector<PowerTrace> traces = condition(std::move(moved), site);
    benchmark::DoNotOptimize(find_passes(traces.front()));
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(input.time_s.size()));
}

BENCHMARK_CAPTURE(condition_trace, ten_kilohertz_steady, 1e4, 0.0, 0.0)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(condition_trace, ten_kilohertz_flicker_and_dusk, 1e4, 1e-8, 1e-7)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(condition_trace, one_kilohertz_flicker_and_dusk, 1e3, 1e-8, 1e-7)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace vildar
