#include "synth/psf.h"

#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

#include "core/quantity.h"

namespace vildar {
namespace {

// Mean over the disc of the PSF of a point, on a fine polar grid.
double brute_force(const PsfShape& shape, double radius_px, double disc_px) {
  const double s2 = shape.core_sigma_px * shape.core_sigma_px;
  const double a2 = shape.wing_scale_px * shape.wing_scale_px;
  const int rings = 400, angles = 300;
  double sum = 0.0;
  for (int i = 0; i < rings; ++i) {
    const double s_px = disc_px * (i + 0.5) / rings;
    const double share = 2.0 * s_px / (disc_px * rings * angles);
    for (int j = 0; j < angles; ++j) {
      const double cosine = std::cos(kPi * (j + 0.5) / angles);
      const double r2 = radius_px * radius_px + s_px * s_px - 2.0 * radius_px * s_px * cosine;
      const double light = (1.0 - shape.wing_share) * std::exp(-0.5 * r2 / s2) / (2.0 * kPi * s2) +
                           shape.wing_share * (0.5 * shape.wing_exponent - 1.0) / (kPi * a2) *
                               std::pow(1.0 + r2 / a2, -0.5 * shape.wing_exponent);
      sum += share * light;
    }
  }
  return sum;
}

TEST(Psf, ProfileIsTheDiscThroughTheSpread) {
  constexpr double kOfPeak = 1e-4;          // both quadratures, and cubic interpolation
  constexpr double kRelativeFarOut = 3e-3;  // the far part is tabulated linearly
  const PsfShape shape{0.9, 0.05, 2.0, 2.5};
  const Psf psf(shape, 500.0);
  for (const double disc_px : {0.05, 0.7, 3.0, 12.0}) {
    const LampProfile profile = psf.profile(disc_px);
    const double peak = brute_force(shape, 0.0, disc_px);
    for (const double radius_px : {0.0, 0.33, 0.9, 2.1, 3.0, 5.2, 11.0, 12.0, 13.1, 20.0, 40.0})
      EXPECT_NEAR(profile.near(radius_px) + profile.far(radius_px),
                  brute_force(shape, radius_px, disc_px), kOfPeak * peak)
          << "disc " << disc_px << " radius " << radius_px;
    for (const double radius_px : {20.0, 40.0, 47.0, 49.0, 80.0, 300.0})
      EXPECT_NEAR((profile.near(radius_px) + profile.far(radius_px)) /
                      brute_force(shape, radius_px, disc_px),
                  1.0, kRelativeFarOut)
          << "disc " << disc_px << " radius " << radius_px;
  }
}

TEST(Psf, LightWithinACircleFollowsTheClosedForm) {
  const PsfShape shape{1.1, 0.08, 2.5, 3.0};
  const Psf psf(shape, 500.0);
  const LampProfile profile = psf.profile(0.01);
  for (const double reach_px : {5.0, 30.0, 120.0}) {
    double inside = 0.0;
    constexpr double kStep_px = 0.01;
    for (double r_px = 0.5 * kStep_px; r_px < reach_px; r_px += kStep_px)
      inside += 2.0 * kPi * r_px * kStep_px * (profile.near(r_px) + profile.far(r_px));
    const double r2 = reach_px * reach_px;
    const double expected = (1.0 - shape.wing_share) * (1.0 - std::exp(-0.5 * r2 / (1.1 * 1.1))) +
                            shape.wing_share * (1.0 - std::pow(1.0 + r2 / (2.5 * 2.5), -0.5));
    EXPECT_NEAR(inside, expected, 1e-4) << reach_px;
  }
}

TEST(Psf, RefusesWhatItCannotRender) {
  EXPECT_THROW(Psf({0.4, 0.03, 2.0, 2.5}, 100.0), std::invalid_argument);
  EXPECT_THROW(Psf({0.9, 1.0, 2.0, 2.5}, 100.0), std::invalid_argument);
  EXPECT_THROW(Psf({0.9, 0.03, 2.0, 2.0}, 100.0), std::invalid_argument);
  const Psf psf({}, 100.0);
  EXPECT_THROW(psf.profile(0.0), std::domain_error);
  EXPECT_THROW(psf.profile(std::nan("")), std::domain_error);
}

}  // namespace
}  // namespace vildar
