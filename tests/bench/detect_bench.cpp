// Run with the `bench` preset. The floor is the plain maximum of the same bytes: no detector can
// look at a frame for less. Frames rotate through more memory than the caches hold, as decoded ones
// do.

#include <benchmark/benchmark.h>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <memory>
#include <vector>

#include "core/random.h"
#include "detect/detector.h"
#include "detect/run_scan.h"

namespace vildar {
namespace {

constexpr int kWidth = 1920;
constexpr int kHeight = 1080;
constexpr int kFrames = 24;

/// Full-HD frames, limited range, noise of one code, `lamps` saturated lamps with glare.
std::vector<Frame> night_frames(int lamps) {
  auto pixels = std::make_shared<std::vector<std::uint8_t>>(static_cast<std::size_t>(kWidth) *
                                                            kHeight * kFrames);
  Random random(3);
  std::uint8_t* first = pixels->data();
  for (int i = 0; i < kWidth * kHeight; ++i)
    first[i] = static_cast<std::uint8_t>(std::lround(18.0 + random.normal()));
  for (int lamp = 0; lamp < lamps; ++lamp) {
    const double u = random.uniform(60.0, kWidth - 60.0), v = random.uniform(60.0, kHeight - 60.0);
    const double spread_px = random.uniform(1.5, 4.0);
    for (int y = static_cast<int>(v) - 40; y < v + 40; ++y)
      for (int x = static_cast<int>(u) - 40; x < u + 40; ++x) {
        const double r2 = (x - u) * (x - u) + (y - v) * (y - v);
        const double code =
            600.0 * std::exp(-0.5 * r2 / (spread_px * spread_px)) + 25.0 / (1.0 + r2 / 200.0);
        std::uint8_t& pixel = first[y * kWidth + x];
        pixel = static_cast<std::uint8_t>(std::min(235.0, pixel + code));
      }
  }
  std::vector<Frame> frames(kFrames);
  for (int i = 0; i < kFrames; ++i) {
    std::uint8_t* data = first + static_cast<std::size_t>(i) * kWidth * kHeight;
    if (i > 0) std::memcpy(data, first, static_cast<std::size_t>(kWidth) * kHeight);
    frames[i].luma = {pixels, data, kWidth, kWidth, kHeight, 8, 16, 235};
  }
  return frames;
}

#if defined(__x86_64__)
__attribute__((target("avx2"))) int maximum_of(const std::uint8_t* data, std::size_t size) {
  // Written out: -O2 does not unroll, and the floor would lie higher for it.
  __m256i a = {}, b = {}, c = {}, d = {};
  const auto load = [data](std::size_t at) __attribute__((target("avx2"))) {
    return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(data + at));
  };
  for (std::size_t at = 0; at + 128 <= size; at += 128) {
    a = _mm256_max_epu8(a, load(at));
    b = _mm256_max_epu8(b, load(at + 32));
    c = _mm256_max_epu8(c, load(at + 64));
    d = _mm256_max_epu8(d, load(at + 96));
  }
  const __m256i most[4] = {a, b, c, d};
  std::uint8_t lanes[128];
  std::memcpy(lanes, most, sizeof(lanes));
  return *std::max_element(lanes, lanes + 128);
}
#else
int maximum_of(const std::uint8_t* data, std::size_t size) {
  return *std::max_element(data, data + size);
}
#endif

/// Turn by turn with the plain maximum, of the next frame: what else the machine does strikes both.
void run_scan(benchmark::State& state) {
  using Clock = std::chrono::steady_clock;
  const std::vector<Frame> frames = night_frames(static_cast<int>(state.range(0)));
  std::vector<PixelRun> runs;
  RunGroups groups;
  std::vector<double> scan_us, maximum_us;
  std::size_t i = 0;
  for (auto _ : state) {
    const Clock::time_point start = Clock::now();
    find_runs(frames[i++ % kFrames].luma, 40, runs);
    group_runs(runs, groups);
    benchmark::DoNotOptimize(groups.count());
    const Clock::time_point middle = Clock::now();
    benchmark::DoNotOptimize(
        maximum_of(frames[i++ % kFrames].luma.data, static_cast<std::size_t>(kWidth) * kHeight));
    const Clock::time_point end = Clock::now();
    scan_us.push_back(std::chrono::duration<double, std::micro>(middle - start).count());
    maximum_us.push_back(std::chrono::duration<double, std::micro>(end - middle).count());
  }
  const auto median = [](std::vector<double>& all) {
    const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
    std::nth_element(all.begin(), middle, all.end());
    return *middle;
  };
  state.counters["scan_us"] = median(scan_us);
  state.counters["plain_maximum_us"] = median(maximum_us);
  state.counters["scan_over_maximum"] = median(scan_us) / median(maximum_us);
}

void detect(benchmark::State& state) {
  const std::vector<Frame> frames = night_frames(static_cast<int>(state.range(0)));
  Detector detector(DetectOptions{}, Response(), std::nullopt);
  std::size_t i = 0;
  for (auto _ : state)
    benchmark::DoNotOptimize(detector.detect(frames[i++ % kFrames]).blobs.size());
}

BENCHMARK(run_scan)->Arg(0)->Arg(4)->Arg(12)->Unit(benchmark::kMicrosecond);
BENCHMARK(detect)->Arg(0)->Arg(4)->Arg(12)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace vildar
