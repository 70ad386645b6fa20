#include <cmath>

#include <benchmark/benchmark.h>

#include "estimate/power_estimators.h"
#include "estimate/power_filter.h"
#include "estimate/power_pass.h"
#include "estimate/power_slope.h"
#include "estimate/sliding_slope.h"

namespace vildar {
namespace {

using namespace power_pass;

// 300 samples of the paper's pass at 40 dB.
struct Scene {
  explicit Scene(double cosine = 0.0, const Window& window = kWindows[0])
      : samples(straight_window(window, cosine)), sigma(sigma_w(40.0)) {
    Random random(1);
    samples.power_w = with_noise(samples.power_w, sigma, random);
  }
  Samples samples;
  double sigma;
};

void PaperLs300(benchmark::State& state) {
  const Scene scene;
  const PowerLaw law{1.0, kExponent, 0.0};
  for (auto _ : state)
    benchmark::DoNotOptimize(fit_power_slope(scene.samples.time_s, scene.samples.power_w, law,
                                             Metres(kPerpendicular_m)));
}
BENCHMARK(PaperLs300)->Unit(benchmark::kMicrosecond);

// The same line with std::pow and one sample at a time, to compare with on any machine.
void ScalarLs300(benchmark::State& state) {
  const Scene scene;
  const auto& [time_s, power_w] = scene.samples;
  for (auto _ : state) {
    double n = 0.0, t = 0.0, r = 0.0, tt = 0.0, tr = 0.0;
    for (std::size_t i = 0; i < time_s.size(); ++i) {
      if (!(power_w[i] > 0.0)) continue;
      const double along_m2 =
          std::pow(power_w[i], -2.0 / kExponent) - kPerpendicular_m * kPerpendicular_m;
      if (!(along_m2 >= 0.0)) continue;
      const double along_m = std::sqrt(along_m2);
      n += 1.0;
      t += time_s[i];
      r += along_m;
      tt += time_s[i] * time_s[i];
      tr += time_s[i] * along_m;
    }
    double speed_mps = -(n * tr - t * r) / (n * tt - t * t);
    benchmark::DoNotOptimize(speed_mps);
  }
}
BENCHMARK(ScalarLs300)->Unit(benchmark::kMicrosecond);

void PaperLsSlidingPerSample(benchmark::State& state) {
  const Scene scene;
  SlidingPowerSlope slope(PowerLaw{1.0, kExponent, 0.0}, Metres(kPerpendicular_m),
                          static_cast<std::size_t>(state.range(0)));
  double t_s = 0.0;
  std::size_t i = 0;
  for (auto _ : state) {
    slope.push(t_s += 1e-3, scene.samples.power_w[i]);
    i = i + 1 == scene.samples.power_w.size() ? 0 : i + 1;
    benchmark::DoNotOptimize(slope.speed_mps());
  }
}
BENCHMARK(PaperLsSlidingPerSample)->Arg(100)->Arg(1000)->Arg(10000)->Unit(benchmark::kNanosecond);

template <PowerMethod method>
void Method300(benchmark::State& state) {
  const double cosine = state.range(0) == 0 ? 0.0 : kCosine;
  const Scene scene(cosine, kWindows[state.range(1)]);
  const PowerProblem problem = straight_problem(scene.samples, cosine, scene.sigma);
  for (auto _ : state) benchmark::DoNotOptimize(estimate_power(problem, method));
}
BENCHMARK(Method300<PowerMethod::weighted_ls>)->Args({0, 0})->Unit(benchmark::kMicrosecond);
BENCHMARK(Method300<PowerMethod::max_likelihood>)
    ->Args({0, 0})
    ->Args({0, 2})
    ->Args({1, 0})
    ->Args({1, 2})
    ->Unit(benchmark::kMicrosecond);
BENCHMARK(Method300<PowerMethod::huber>)->Args({0, 0})->Unit(benchmark::kMicrosecond);
BENCHMARK(Method300<PowerMethod::kalman>)->Args({0, 0})->Unit(benchmark::kMicrosecond);
BENCHMARK(Method300<PowerMethod::ceres>)->Args({0, 0})->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace vildar
