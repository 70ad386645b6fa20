// The same lamps measured by the fit and by SEP, the library form of SExtractor; prints a table of
// docs/photometry.md.

extern "C" {
#include <sep.h>
}

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <functional>
#include <optional>
#include <vector>

#include "detect/gaussian_spot.h"
#include "detect/lamp_fit.h"
#include "detect/lamp_pictures.h"
#include "detect/linear_camera.h"

namespace vildar {
namespace {

constexpr int kTrials = 1000;

struct SepLight {
  Eigen::Vector2d barycentre_px, windowed_px;
  double aperture = 0.0;
};

/// The brightest object that SEP extracts, with SExtractor's settings, five sigmas above a
/// background that it is told, and an aperture about its windowed centre.
std::optional<SepLight> sep_light(const FrameLight& frame, double window_px, double aperture_px) {
  std::vector<double> light;
  for (int v = 0; v < frame.luma.height_px; ++v)
    for (int u = 0; u < frame.luma.width_px; ++u)
      light.push_back(static_cast<double>(frame.linear[frame.luma.code(u, v)]) -
                      LinearCamera::kBackground_e / LinearCamera::kFullWell_e);
  sep_image image{};
  image.data = light.data();
  image.dtype = SEP_TDOUBLE;
  image.w = frame.luma.width_px;
  image.h = frame.luma.height_px;
  image.noise_type = SEP_NOISE_STDDEV;
  image.noiseval = std::sqrt(LinearCamera::variance(0.0));
  const float kernel[9] = {1, 2, 1, 2, 4, 2, 1, 2, 1};
  sep_catalog* found = nullptr;
  if (sep_extract(&image, 5.0F, SEP_THRESH_REL, 5, kernel, 3, 3, SEP_FILTER_CONV, 32, 0.005, 1, 1.0,
                  &found) != 0)
    return std::nullopt;
  std::optional<SepLight> result;
  float most = 0.0F;
  for (int i = 0; i < found->nobj; ++i) {
    if (found->flux[i] <= most) continue;
    most = found->flux[i];
    SepLight one;
    one.barycentre_px = {found->x[i], found->y[i]};
    int steps = 0;
    short flags = 0;
    sep_windowed(&image, found->x[i], found->y[i], window_px, 11, 0, &one.windowed_px.x(),
                 &one.windowed_px.y(), &steps, &flags);
    double sigma = 0.0, area = 0.0;
    sep_sum_circle(&image, one.windowed_px.x(), one.windowed_px.y(), aperture_px, 0, 5, 0,
                   &one.aperture, &sigma, &area, &flags);
    result = one;
  }
  sep_catalog_free(found);
  return result;
}

struct Errors {
  double square_px2 = 0.0, bias = 0.0, square = 0.0;
  void add(const Eigen::Vector2d& off_px, double off) {
    square_px2 += 0.5 * off_px.squaredNorm();
    bias += off;
    square += off * off;
  }
  double centre_px(int n) const { return std::sqrt(square_px2 / n); }
  double rmse(int n) const { return 100.0 * std::sqrt(square / n); }
};

struct Cell {
  Errors fit, windowed, barycentre;
  int found = 0;

  /// `light_of` gives the picture of a lamp in a place; `whole` is the share of its flux that an
  /// ideal aperture holds.
  Cell(LampFitter& fitter, int size_px, double size_sigma_px, double flux, double aperture_px,
       double whole, std::optional<double> radius_px,
       const std::function<std::vector<double>(Eigen::Vector2d)>& light_of) {
    const LinearCamera camera;
    Random random(37);
    for (int trial = 0; trial < kTrials; ++trial) {
      const Eigen::Vector2d at(size_px / 2 + random.uniform(-0.5, 0.5),
                               size_px / 2 + random.uniform(-0.5, 0.5));
      const FrameLight frame = camera.expose(light_of(at), size_px, random);
      const std::optional<SepLight> sep = sep_light(frame, size_sigma_px, aperture_px);
      LampGuess guess = guess_of(frame, size_sigma_px);
      guess.radius_px = radius_px;
      const LampsFit& lamps = fitter.fit(frame, {{guess}}, radius_px.has_value());
      if (!sep || lamps.lamps.empty()) continue;
      ++found;
      fit.add(lamps.lamps[0].centre_px - at, lamps.lamps[0].flux / flux - 1.0);
      windowed.add(sep->windowed_px - at, sep->aperture / whole / flux - 1.0);
      barycentre.add(sep->barycentre_px - at, 0.0);
    }
  }
  void print(const char* kind, double size, double brightness) const {
    std::printf("%-8s %5.1f %8.2f | %8.4f %8.4f %8.4f | %8.2f %8.2f %8.2f | %5d\n", kind, size,
                brightness, fit.centre_px(found), windowed.centre_px(found),
                barycentre.centre_px(found), fit.rmse(found), windowed.rmse(found),
                100.0 * windowed.bias / found, found);
  }
};

TEST(SepStudy, TheFitBesideSep) {
#ifndef NDEBUG
  GTEST_SKIP() << "studies need an optimised build (preset bench or ci)";
#endif
  std::printf("%-8s %5s %8s | %8s %8s %8s | %8s %8s %8s | %5s\n", "lamp", "size", "white", "fit px",
              "win px", "iso px", "fit %", "aper %", "bias %", "found");
  for (const double sigma_px : {1.0, 1.5, 2.5})
    for (const double peak : {0.03, 0.3, 0.9}) {
      LampFitter fitter(PsfShape{sigma_px, 0.0, 2.0, 2.5});
      const int size_px = 2 * static_cast<int>(std::ceil(5.0 * sigma_px + 4.0)) + 1;
      const double flux = peak * 2.0 * kPi * sigma_px * sigma_px;
      const double aperture_px = 3.5 * sigma_px;
      const Cell cell(fitter, size_px, sigma_px, flux, aperture_px,
                      1.0 - std::exp(-0.5 * 3.5 * 3.5), 0.0, [&](const Eigen::Vector2d& at) {
                        return GaussianSpot(size_px, at.x(), at.y(), sigma_px, flux).light;
                      });
      cell.print("gaussian", sigma_px, peak);
      EXPECT_GT(cell.found, kTrials * 9 / 10);
      EXPECT_LT(cell.fit.square_px2, cell.windowed.square_px2);
      EXPECT_LT(cell.fit.square, 1.1 * cell.windowed.square);
    }
  const PsfShape glare{0.9, 0.03, 2.0, 2.5};
  constexpr int kSize_px = 81;
  LampPictures pictures(glare, kSize_px);
  LampFitter fitter(glare);
  for (const double disc_px : {0.5, 3.0})
    for (const double times : {5.0, 20.0, 500.0}) {
      const double flux = pictures.flux(disc_px, times);
      const Cell cell(fitter, kSize_px, std::hypot(0.9, 0.5 * disc_px), flux, 12.0, 1.0,
                      std::nullopt, [&](const Eigen::Vector2d& at) {
                        return pictures.of({LampPictures::lamp(at.x(), at.y(), disc_px, flux)});
                      });
      cell.print("clipped", disc_px, times);
      EXPECT_GT(cell.found, kTrials * 9 / 10);
      EXPECT_LT(cell.fit.square, cell.windowed.square);
    }
}

}  // namespace
}  // namespace vildar
