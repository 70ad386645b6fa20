// Light of lamps of whole passes through the encoder, as a run tells it, before and after each lamp
// is held to one size; prints the table of docs/photometry.md.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "capture/clip_source.h"
#include "detect/detector.h"
#include "estimate/vehicle.h"
#include "support/rendered_clip.h"
#include "support/temporary_folder.h"
#include "track/tracker.h"

namespace vildar {
namespace {

struct Lights {
  std::vector<double> error_ln;  // of fitted lamps
  double covered = 0.0, lamps = 0.0;

  void add(const std::optional<LampLight>& light, double truth) {
    lamps += 1.0;
    if (!light || !light->told()) return;
    error_ln.push_back(std::log(light->flux / truth));
    covered += std::abs(light->flux - truth) < 1.96 * light->flux_sigma;
  }
  double share_covered() const { return covered / static_cast<double>(error_ln.size()); }
  double rmse() const {
    double square = 0.0;
    for (const double one : error_ln) square += one * one;
    return std::sqrt(square / static_cast<double>(error_ln.size()));
  }
  double median() const {
    std::vector<double> sorted = error_ln;
    std::sort(sorted.begin(), sorted.end());
    return sorted[sorted.size() / 2];
  }
};

struct Found {
  Lights alone, held;
};

Found measured(const Scenario& scenario) {
  const TemporaryFolder folder;
  const auto clip = folder.path() / clip_file_name(scenario.encoder.codec);
  Renderer renderer(scenario);
  write_clip(clip, scenario, renderer);

  const Site& site = scenario.site;
  const ImageScene& image = scenario.image;
  DetectOptions options;
  options.lossy = true;
  Detector detector(options, Response(*site.camera), site.camera->exposure_s, psf_of(image));
  Tracker tracker(TrackOptions{}, site);
  ClipSource source(clip);
  std::vector<VehicleTrack> tracks;
  const auto keep = [&](std::vector<VehicleTrack> ended) {
    tracks.insert(tracks.end(), ended.begin(), ended.end());
  };
  while (const auto frame = source.next()) {
    BlobFrame blobs = detector.detect(*frame);
    keep(tracker.update(blobs));
  }
  keep(tracker.finish());

  Found found;
  for (const VehicleTrack& track : tracks) {
    const VehicleEstimate estimate = estimate_vehicle(track, site, {});
    for (std::size_t i = 0; i < track.sightings.size(); ++i) {
      const VehicleSighting &before = track.sightings[i], &after = estimate.rows[i].sighting;
      const std::vector<LampImage> truth =
          renderer.lamps(static_cast<double>(before.frame) / scenario.frame_rate_hz);
      for (const auto lamp_of : {&VehicleSighting::left, &VehicleSighting::right}) {
        const auto& lamp = before.*lamp_of;
        if (!lamp || has(lamp->defects, Defect::cut_by_edge)) continue;
        for (const LampImage& one : truth) {
          constexpr double kSame_px = 1.5;
          if (one.streak_px > 0.0 || (one.centre_px - lamp->centre_px).norm() > kSame_px) continue;
          const double flux = one.flux / image.full_well_e / *site.camera->exposure_s;
          found.alone.add(lamp->lamp, flux);
          found.held.add((after.*lamp_of)->lamp, flux);
        }
      }
    }
  }
  return found;
}

TEST(LampSizeStudy, LightOfWholePassesThroughTheEncoder) {
#ifndef NDEBUG
  GTEST_SKIP() << "studies need an optimised build (preset bench or ci)";
#endif
  const Scenario plain = load_scenario(VILDAR_SOURCE_DIR "/tests/bench/four_vehicles_1080p.yaml");
  std::printf("%5s %6s | %6s | %-29s | %s\n", "core", "light", "lamps",
              "by itself: told, rmse, median, in 95", "one size of a lamp");
  for (const double core_px : {0.9, 0.65, 1.5})
    for (const double light : {1.0, 0.2, 0.03, 0.008}) {
      Scenario scenario = plain;
      scenario.duration_s = 5.5;
      scenario.image.core_sigma_px = core_px;
      scenario.image.electrons_per_lux_s *= light;
      const Found found = measured(scenario);
      std::printf("%5.2f %6.3f | %6.0f |", core_px, light, found.alone.lamps);
      for (const Lights* one : {&found.alone, &found.held})
        std::printf(" %3.0f %% %5.1f %% %+5.1f %% %5.1f %% |",
                    100.0 * static_cast<double>(one->error_ln.size()) / one->lamps,
                    100.0 * one->rmse(), 100.0 * one->median(), 100.0 * one->share_covered());
      std::printf("\n");
      std::fflush(stdout);
      // Of lamps that hardly clip a radius tells little of the light.
      constexpr double kHardlyClips = 0.01, kAlike = 1.02;
      EXPECT_LT(found.held.rmse(), found.alone.rmse() * (light < kHardlyClips ? kAlike : 1.0));
      EXPECT_GE(found.held.error_ln.size(), found.alone.error_ln.size());
      EXPECT_GT(found.held.share_covered(), 0.9);
    }
}

}  // namespace
}  // namespace vildar
