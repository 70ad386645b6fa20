// Light and centres of the lamps of a rendered clip, through the encoder and the decoder; prints
// the table of docs/photometry.md.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "capture/clip_source.h"
#include "detect/detector.h"
#include "support/rendered_clip.h"
#include "support/temporary_folder.h"

namespace vildar {
namespace {

struct Found {
  std::vector<double> centre_px;  // errors, per lamp and frame
  std::vector<double> flux_ln;    // of fitted lamps, ln(measured / true)
  double covered = 0.0, covered_axes = 0.0, bad = 0.0, lamps = 0.0;
};

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// When it was rendered: some containers round stamps to milliseconds, in which a near lamp moves by
// 0.04 px.
double time_of(const Frame& frame, const Scenario& scenario) {
  return static_cast<double>(frame.index) / scenario.frame_rate_hz;
}

Found measured(const Scenario& scenario, bool psf_known, int least_area_px) {
  const TemporaryFolder folder;
  const auto clip = folder.path() / clip_file_name(scenario.encoder.codec);
  Renderer renderer(scenario);
  write_clip(clip, scenario, renderer);

  const CameraSite& camera = *scenario.site.camera;
  const ImageScene& image = scenario.image;
  std::optional<PsfSite> psf;
  if (psf_known) psf = psf_of(image);
  DetectOptions options;
  options.lossy = scenario.encoder.codec != ClipCodec::ffv1;
  Detector detector(options, Response(camera), camera.exposure_s, psf);
  ClipSource source(clip);
  Found found;
  constexpr double kSame_px = 3.0;
  while (const auto frame = source.next()) {
    const std::vector<LampImage> truth = renderer.lamps(time_of(*frame, scenario));
    for (const Blob& blob : detector.detect(*frame).blobs) {
      if (blob.area_px < least_area_px || has(blob.defects, Defect::cut_by_edge)) continue;
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
      const Eigen::Vector2d off_px = (blob.centre_px - lamp->centre_px).cwiseAbs();
      for (const int axis : {0, 1})
        found.covered_axes += off_px[axis] < 1.96 * blob.centre_sigma_px[axis];
      if (!blob.lamp || !blob.lamp->told()) continue;
      const double true_flux = lamp->flux / image.full_well_e / *camera.exposure_s;
      found.flux_ln.push_back(std::log(blob.lamp->flux / true_flux));
      found.covered += std::abs(blob.lamp->flux - true_flux) < 1.96 * blob.lamp->flux_sigma;
    }
  }
  return found;
}

struct Coded {
  const char* name;
  ClipCodec codec;
  int mbit_per_s;
  double exposure_s = 0.001, rolling_shutter_s = 0.0;
};

Scenario scenario_of(Scenario scenario, const Coded& coded, double light) {
  scenario.duration_s = 1.5;
  scenario.encoder.codec = coded.codec;
  scenario.encoder.bitrate_bps.reset();
  if (coded.mbit_per_s > 0) scenario.encoder.bitrate_bps = 1000000 * coded.mbit_per_s;
  scenario.image.electrons_per_lux_s *=
      light * *scenario.site.camera->exposure_s / coded.exposure_s;
  scenario.site.camera->exposure_s = coded.exposure_s;
  scenario.site.camera->rolling_shutter_s = coded.rolling_shutter_s;
  return scenario;
}

constexpr int kLeastArea_px = 20;

TEST(ClipPhotometryStudy, LightAndCentresThroughTheEncoder) {
#ifndef NDEBUG
  GTEST_SKIP() << "studies need an optimised build (preset bench or ci)";
#endif
  const Scenario plain = load_scenario(VILDAR_SOURCE_DIR "/tests/bench/four_vehicles_1080p.yaml");
  std::printf("%-22s %7s | %6s %8s | %8s %8s %6s | %6s %7s %8s %6s\n", "codec", "light", "lamps",
              "bad fit", "px, 50 %", "px, 95 %", "in 95", "fitted", "rmse %", "median %", "in 95");
  for (const Coded& coded : {Coded{"h264", ClipCodec::h264, 7},
                             Coded{"h264 blurred, rolling", ClipCodec::h264, 7, 0.008, 0.02},
                             Coded{"h264", ClipCodec::h264, 3}, Coded{"h264", ClipCodec::h264, 20},
                             Coded{"h265", ClipCodec::h265, 4}, Coded{"mjpeg", ClipCodec::mjpeg, 0},
                             Coded{"ffv1", ClipCodec::ffv1, 0}})
    for (const double light : {1.0, 0.2, 0.03, 0.008, 0.001}) {
      const Scenario scenario = scenario_of(plain, coded, light);
      const Found found = measured(scenario, true, kLeastArea_px);
      double square = 0.0;
      for (const double ln : found.flux_ln) square += ln * ln;
      const double n = std::max(1.0, static_cast<double>(found.flux_ln.size()));
      std::printf("%-22s %2d %4.3f | %6.0f %8.3f | %8.3f %8.3f %6.3f | %6.0f %7.2f %8.2f %6.3f\n",
                  coded.name, coded.mbit_per_s, light, found.lamps, found.bad / found.lamps,
                  quantile(found.centre_px, 0.5), quantile(found.centre_px, 0.95),
                  found.covered_axes / (2.0 * found.lamps),
                  static_cast<double>(found.flux_ln.size()), 100.0 * std::sqrt(square / n),
                  100.0 * quantile(found.flux_ln, 0.5), found.covered / n);
      std::fflush(stdout);
      EXPECT_GT(found.lamps, 100.0);
    }
}

// Lamps that do not clip, where the site gives no PSF.
TEST(ClipPhotometryStudy, PlainCentresThroughTheEncoder) {
#ifndef NDEBUG
  GTEST_SKIP() << "studies need an optimised build (preset bench or ci)";
#endif
  const Scenario plain = load_scenario(VILDAR_SOURCE_DIR "/tests/bench/four_vehicles_1080p.yaml");
  std::printf("%-6s %7s | %6s %8s %8s %6s\n", "codec", "light", "lamps", "px, 50 %", "px, 95 %",
              "in 95");
  for (const Coded& coded :
       {Coded{"h264", ClipCodec::h264, 3}, Coded{"h264", ClipCodec::h264, 7},
        Coded{"h264", ClipCodec::h264, 20}, Coded{"h265", ClipCodec::h265, 4},
        Coded{"mjpeg", ClipCodec::mjpeg, 0}, Coded{"ffv1", ClipCodec::ffv1, 0}})
    for (const double light : {0.008, 0.001}) {
      const Found found = measured(scenario_of(plain, coded, light), false, 1);
      const double covered = found.covered_axes / (2.0 * found.lamps);
      std::printf("%-6s %2d %4.3f | %6.0f %8.3f %8.3f %6.3f\n", coded.name, coded.mbit_per_s, light,
                  found.lamps, quantile(found.centre_px, 0.5), quantile(found.centre_px, 0.95),
                  covered);
      std::fflush(stdout);
      EXPECT_GT(covered, 0.92) << coded.name << ' ' << coded.mbit_per_s << ' ' << light;
    }
}

// What coding does to the pixels about lamps that clip, in codes, by distance from the rim and by
// the slope of the uncoded picture.
class CodingErrors {
 public:
  /// Within `own_px` of the lamp what clips is its own.
  void add(const LumaView& before, const LumaView& after, const LampImage& lamp, double own_px) {
    constexpr int kReach_px = 40;
    const int u0 = static_cast<int>(lamp.centre_px.x()), v0 = static_cast<int>(lamp.centre_px.y());
    if (u0 < kReach_px + 9 || v0 < kReach_px + 9 || u0 + kReach_px + 9 >= before.width_px ||
        v0 + kReach_px + 9 >= before.height_px)
      return;
    double clipped = 0.0;
    for (int v = v0 - kReach_px; v <= v0 + kReach_px; ++v)
      for (int u = u0 - kReach_px; u <= u0 + kReach_px; ++u)
        clipped += before.code(u, v) >= before.white_code &&
                   (Eigen::Vector2d(u, v) - lamp.centre_px).norm() < own_px;
    const double rim_px = std::sqrt(clipped / 3.141592653589793);
    for (int v = v0 - kReach_px; v <= v0 + kReach_px; ++v)
      for (int u = u0 - kReach_px; u <= u0 + kReach_px; ++u) {
        const double from_px = (Eigen::Vector2d(u, v) - lamp.centre_px).norm() - rim_px;
        if (!(from_px > -6.0 && from_px < 24.0)) continue;
        const auto error = [&](int du) {
          return static_cast<double>(after.code(u + du, v) - before.code(u + du, v));
        };
        const double slope = 0.5 * std::hypot(before.code(u + 1, v) - before.code(u - 1, v),
                                              before.code(u, v + 1) - before.code(u, v - 1));
        Sum* sums[] = {
            &by_distance_[static_cast<std::size_t>(from_px + 6.0) / 2],
            &by_slope_[static_cast<std::size_t>(std::min(std::log2(slope + 1.0) * 1.5, 9.0))]};
        for (Sum* sum : sums) {
          sum->n += 1.0;
          sum->level += before.code(u, v);
          sum->error += error(0);
          sum->square += error(0) * error(0);
          for (std::size_t k = 0; k < 4; ++k) sum->along[k] += error(0) * error(1 << k);
        }
      }
  }
  void print() const {
    for (const bool distance : {true, false}) {
      const std::span<const Sum> table =
          distance ? std::span<const Sum>(by_distance_) : std::span<const Sum>(by_slope_);
      std::printf("%-12s %8s %7s %7s %7s | %6s %6s %6s %6s\n",
                  distance ? "from rim px" : "codes/px", "pixels", "level", "mean", "rms", "1 px",
                  "2 px", "4 px", "8 px");
      for (std::size_t i = 0; i < table.size(); ++i) {
        const Sum& sum = table[i];
        if (sum.n < 100.0) continue;
        const double low = distance ? 2.0 * static_cast<double>(i) - 6.0
                                    : std::exp2(static_cast<double>(i) / 1.5) - 1.0;
        std::printf("%-12.1f %8.0f %7.1f %+7.2f %7.2f |", low, sum.n, sum.level / sum.n,
                    sum.error / sum.n, std::sqrt(sum.square / sum.n));
        for (const double one : sum.along) std::printf(" %+6.2f", one / sum.square);
        std::printf("\n");
      }
    }
  }

 private:
  struct Sum {
    double n = 0.0, level = 0.0, error = 0.0, square = 0.0;
    std::array<double, 4> along{};  // products with the error so many pixels to the right
  };
  std::array<Sum, 15> by_distance_;
  std::array<Sum, 10> by_slope_;
};

TEST(ClipPhotometryStudy, WhatCodingDoesAboutLamps) {
#ifndef NDEBUG
  GTEST_SKIP() << "studies need an optimised build (preset bench or ci)";
#endif
  Scenario scenario = load_scenario(VILDAR_SOURCE_DIR "/tests/bench/four_vehicles_1080p.yaml");
  scenario.duration_s = 1.5;
  for (const int bitrate_bps : {3000000, 7000000, 20000000}) {
    scenario.encoder.bitrate_bps = bitrate_bps;
    const TemporaryFolder folder;
    const auto clip = folder.path() / clip_file_name(scenario.encoder.codec);
    Renderer renderer(scenario);
    write_clip(clip, scenario, renderer);
    const int frames = static_cast<int>(scenario.duration_s * scenario.frame_rate_hz);
    ClipSource source(clip);
    CodingErrors errors;
    while (const auto frame = source.next()) {
      const double time_s = time_of(*frame, scenario);
      const Frame before = renderer.image(time_s);
      const std::vector<LampImage> lamps = renderer.lamps(time_s);
      for (const LampImage& lamp : lamps) {
        double nearest_px = 1e9;
        for (const LampImage& other : lamps)
          if (&other != &lamp)
            nearest_px = std::min(nearest_px, (other.centre_px - lamp.centre_px).norm());
        if (lamp.streak_px == 0.0) errors.add(before.luma, frame->luma, lamp, 0.5 * nearest_px);
      }
    }
    std::printf("%d Mbit/s: %.1f kB a frame\n", bitrate_bps / 1000000,
                1e-3 * static_cast<double>(std::filesystem::file_size(clip)) / frames);
    errors.print();
  }
}

}  // namespace
}  // namespace vildar
