// Light and centres of the lamps of a rendered clip, through the encoder and the decoder; prints
// the table of docs/photometry.md.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "capture/clip_source.h"
#include "detect/detector.h"
#include "support/temporary_folder.h"
#include "synth/clip_writer.h"
#include "synth/renderer.h"

namespace vildar {
namespace {

struct Found {
  std::vector<double> centre_px;  // errors, per lamp and frame
  std::vector<double> flux_ln;    // of fitted lamps, ln(measured / true)
  double covered = 0.0, bad = 0.0, lamps = 0.0;
};

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

Found measured(Scenario scenario, bool calibrated) {
  const TemporaryFolder folder;
  const auto clip = folder.path() / clip_file_name(scenario.encoder.codec);
  Renderer renderer(scenario);
  ClipWriter writer(clip, scenario);
  const int frames = static_cast<int>(scenario.duration_s * scenario.frame_rate_hz);
  for (int i = 0; i < frames; ++i) writer.write(renderer.image(i / scenario.frame_rate_hz));
  writer.commit();

  const CameraSite& camera = *scenario.site.camera;
  const ImageScene& image = scenario.image;
  const PsfSite psf{
      {image.core_sigma_px, image.wing_share, image.wing_scale_px, image.wing_exponent}, 0.0};
  Detector detector(DetectOptions{}, Response(camera), camera.exposure_s,
                    calibrated ? std::optional(psf) : std::nullopt);
  ClipSource source(clip);
  Found found;
  constexpr double kSame_px = 3.0;
  constexpr int kLeastArea_px = 20;
  while (const auto frame = source.next()) {
    const std::vector<LampImage> truth = renderer.lamps(seconds_of(frame->time));
    for (const Blob& blob : detector.detect(*frame).blobs) {
      if (blob.area_px < kLeastArea_px || has(blob.defects, Defect::cut_by_edge)) continue;
      const LampImage* lamp = nullptr;
      double least_px = kSame_px;
      for (const LampImage& one : truth) {
        const double distance_px = (one.centre_px - blob.centre_px).norm();
        if (one.streak_px > 0.0 || distance_px >= least_px) continue;
        least_px = distance_px;
        lamp = &one;
      }
      if (lamp == nullptr) continue;
      found.lamps += 1.0;
      found.bad += has(blob.defects, Defect::bad_fit);
      found.centre_px.push_back(least_px);
      if (!blob.lamp) continue;
      const double true_flux = lamp->flux / image.full_well_e / *camera.exposure_s;
      found.flux_ln.push_back(std::log(blob.lamp->flux / true_flux));
      found.covered += std::abs(blob.lamp->flux - true_flux) < 1.96 * blob.lamp->flux_sigma;
    }
  }
  return found;
}

TEST(ClipPhotometryStudy, LightAndCentresThroughTheEncoder) {
#ifndef NDEBUG
  GTEST_SKIP() << "studies need an optimised build (preset bench or ci)";
#endif
  Scenario scenario = load_scenario(VILDAR_SOURCE_DIR "/tests/bench/four_vehicles_1080p.yaml");
  scenario.duration_s = 1.5;
  const double bright = scenario.image.electrons_per_lux_s;
  std::printf("%-6s %10s %10s | %6s %8s | %8s %8s | %8s %8s %8s %8s\n", "codec", "e/lx/s", "psf",
              "lamps", "bad fit", "px, 50 %", "px, 95 %", "fitted", "rmse %", "median %",
              "in 95 %");
  for (const ClipCodec codec : {ClipCodec::ffv1, ClipCodec::h264})
    for (const double share : {1.0, 0.001})
      for (const bool calibrated : {false, true}) {
        scenario.encoder.codec = codec;
        scenario.image.electrons_per_lux_s = bright * share;
        const Found found = measured(scenario, calibrated);
        double square = 0.0;
        for (const double ln : found.flux_ln) square += ln * ln;
        const double n = std::max(1.0, static_cast<double>(found.flux_ln.size()));
        std::printf("%-6s %10.2g %10s | %6.0f %8.3f | %8.3f %8.3f | %8.0f %8.2f %8.2f %8.3f\n",
                    codec == ClipCodec::h264 ? "h264" : "ffv1", bright * share,
                    calibrated ? "known" : "unknown", found.lamps, found.bad / found.lamps,
                    quantile(found.centre_px, 0.5), quantile(found.centre_px, 0.95),
                    static_cast<double>(found.flux_ln.size()), 100.0 * std::sqrt(square / n),
                    100.0 * quantile(found.flux_ln, 0.5), found.covered / n);
        EXPECT_GT(found.lamps, 100.0);
      }
}

}  // namespace
}  // namespace vildar
