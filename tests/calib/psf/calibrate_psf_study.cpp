// How well a PSF is found, over PSFs and over what the lamps show; prints the table of
// docs/photometry.md.

#include "calib/psf/calibrate_psf.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "lit_crops.h"

namespace vildar {
namespace {

constexpr int kTrials = 10;

struct Errors {
  double square[4] = {}, stated[4] = {};
  int found = 0, inside = 0, refused = 0;
};

Errors errors_of(const PsfShape& truth, int crops, double least, double most) {
  Errors errors;
  Random random(500);
  for (int trial = 0; trial < kTrials; ++trial) {
    const auto outcome = calibrate_psf(lit_crops(truth, crops, least, most, random), false);
    const auto* found = std::get_if<PsfCalibration>(&outcome);
    if (found == nullptr) {
      ++errors.refused;
      continue;
    }
    const PsfShape& shape = found->psf.shape;
    const double error[] = {
        shape.core_sigma_px - truth.core_sigma_px, shape.wing_share - truth.wing_share,
        shape.wing_scale_px - truth.wing_scale_px, shape.wing_exponent - truth.wing_exponent};
    const double std[] = {found->core_sigma_std_px, found->psf.wing_share_std,
                          found->wing_scale_std_px, found->wing_exponent_std};
    ++errors.found;
    for (int k = 0; k < 4; ++k) {
      errors.square[k] += error[k] * error[k];
      errors.stated[k] += std[k] * std[k];
      errors.inside += std::abs(error[k]) < 1.96 * std[k];
    }
  }
  return errors;
}

TEST(CalibratePsfStudy, FindsEachNumberWithinItsSigma) {
#ifndef NDEBUG
  GTEST_SKIP() << "studies need an optimised build (preset bench or ci)";
#endif
  struct Light {
    const char* name;
    double least, most;
  };
  std::printf("%-24s %-14s | %15s %15s %15s %15s | %5s %7s\n", "core share scale exp",
              "times white", "core rms/std", "share %", "scale %", "exponent", "in 95", "refused");
  for (const PsfShape& truth : {PsfShape{0.9, 0.03, 2.0, 2.5}, PsfShape{0.6, 0.01, 1.0, 3.0},
                                PsfShape{1.5, 0.08, 3.0, 2.3}, PsfShape{2.5, 0.05, 4.0, 3.5}})
    for (const Light& light :
         {Light{"0.3 to 2000", 0.3, 2000.0}, Light{"0.3 to 5", 0.3, 5.0},
          Light{"3 to 300", 3.0, 300.0}, Light{"100 to 2000", 100.0, 2000.0}}) {
      const Errors errors = errors_of(truth, 40, light.least, light.most);
      const double n = std::max(errors.found, 1);
      const auto rms = [&](int k) { return std::sqrt(errors.square[k] / n); };
      const auto std = [&](int k) { return std::sqrt(errors.stated[k] / n); };
      std::printf(
          "%4.1f %6.3f %5.1f %5.1f  %-14s | %7.4f %7.4f %7.2f %7.2f %7.2f %7.2f %7.4f %7.4f | "
          "%5.3f "
          "%5d\n",
          truth.core_sigma_px, truth.wing_share, truth.wing_scale_px, truth.wing_exponent,
          light.name, rms(0), std(0), 100.0 * rms(1) / truth.wing_share,
          100.0 * std(1) / truth.wing_share, 100.0 * rms(2) / truth.wing_scale_px,
          100.0 * std(2) / truth.wing_scale_px, rms(3), std(3), errors.inside / (4.0 * n),
          errors.refused);
      std::fflush(stdout);
    }
}

}  // namespace
}  // namespace vildar
