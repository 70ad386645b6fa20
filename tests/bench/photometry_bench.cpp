// Detection and measurement of lamps behind a known point-spread function. Run with the `bench`
// preset. Lamps come in pairs 40 px apart that move by 2 px a frame, to and fro; arguments are
// their number and how far their middle is beyond what a pixel holds, in per cent.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "core/random.h"
#include "detect/detector.h"
#include "synth/light_plane.h"

namespace vildar {
namespace {

constexpr int kWidth = 1920, kHeight = 1080, kFrames = 8;
constexpr double kFullWell_e = 20000.0, kFrame_s = 0.04;
const PsfShape kGlare{0.9, 0.03, 2.0, 2.5};

std::vector<Frame> lamp_frames(int lamps, double times_white) {
  const Psf psf(kGlare, 4400.0);
  LightPlane plane(kWidth, kHeight, psf, 1.0, 0.0);
  const Response response;
  std::vector<std::uint8_t> codes;
  for (int i = 0; i <= 1 << 12; ++i)
    codes.push_back(static_cast<std::uint8_t>(
        std::lround(16.0 + 219.0 * response.fraction_from_linear(i / 4096.0))));
  std::vector<Frame> frames(kFrames);
  Random random(5);
  for (int index = 0; index < kFrames; ++index) {
    plane.clear();
    for (int lamp = 0; lamp < lamps; ++lamp) {
      LampImage image;
      const int pair = lamp / 2;
      image.centre_px = {200.3 + 260.0 * pair + 40.0 * (lamp % 2) + 2.0 * index,
                         300.2 + 55.0 * pair + 1.1 * index};
      image.disc_radius_px = 1.0 + 0.5 * pair;
      const LampProfile profile = psf.profile(image.disc_radius_px);
      image.flux = times_white * kFullWell_e / (profile.near(0.0) + profile.far(0.0));
      plane.add(image);
    }
    auto pixels =
        std::make_shared<std::vector<std::uint8_t>>(static_cast<std::size_t>(kWidth) * kHeight);
    for (int v = 0; v < kHeight; ++v)
      for (int u = 0; u < kWidth; ++u) {
        const double mean_e = plane.at(u, v) + 60.0;
        const double light = (mean_e + random.normal(0.0, std::sqrt(mean_e + 16.0))) / kFullWell_e;
        (*pixels)[static_cast<std::size_t>(v) * kWidth + static_cast<std::size_t>(u)] =
            codes[static_cast<std::size_t>(4096.0 * std::clamp(light, 0.0, 1.0))];
      }
    frames[static_cast<std::size_t>(index)].luma = {
        pixels, pixels->data(), kWidth, kWidth, kHeight, 8, 16, 235};
  }
  return frames;
}

void detect_lamps(benchmark::State& state, bool calibrated) {
  std::vector<Frame> frames =
      lamp_frames(static_cast<int>(state.range(0)), 0.01 * static_cast<double>(state.range(1)));
  Detector detector(DetectOptions{}, Response(), 0.002,
                    calibrated ? std::optional(PsfSite{kGlare, 0.0}) : std::nullopt);
  std::size_t i = 0;
  double fitted = 0.0;
  for (auto _ : state) {
    const std::size_t step = i % (2 * kFrames - 2);
    Frame& frame = frames[std::min(step, 2 * kFrames - 2 - step)];
    frame.time = time_from_seconds<CameraTime>(kFrame_s * static_cast<double>(i));
    for (const Blob& blob : detector.detect(frame).blobs) fitted += blob.lamp.has_value();
    ++i;
  }
  state.counters["lamps_fitted"] = fitted / static_cast<double>(i);
}

BENCHMARK_CAPTURE(detect_lamps, plain, false)
    ->Args({4, 50})
    ->Args({4, 5000})
    ->Args({12, 50})
    ->Args({12, 5000})
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(detect_lamps, fitted, true)
    ->Args({4, 50})
    ->Args({4, 5000})
    ->Args({12, 50})
    ->Args({12, 5000})
    ->Args({12, 100000})
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace vildar
