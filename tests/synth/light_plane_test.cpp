#include "synth/light_plane.h"

#include <gtest/gtest.h>

#include "core/quantity.h"
#include "core/random.h"

namespace vildar {
namespace {

constexpr int kSize_px = 400;

struct Moments {
  double flux = 0.0, u_px = 0.0, v_px = 0.0;
};

Moments moments_of(const LightPlane& plane, double reach_px, const Eigen::Vector2d& about_px) {
  Moments sum;
  for (int v = 0; v < kSize_px; ++v)
    for (int u = 0; u < kSize_px; ++u) {
      if ((Eigen::Vector2d(u, v) - about_px).norm() > reach_px) continue;
      const double light = plane.at(u, v);
      sum.flux += light;
      sum.u_px += light * u;
      sum.v_px += light * v;
    }
  sum.u_px /= sum.flux;
  sum.v_px /= sum.flux;
  return sum;
}

LampImage lamp_at(double u_px, double v_px, double disc_px) {
  LampImage lamp;
  lamp.centre_px = {u_px, v_px};
  lamp.disc_radius_px = disc_px;
  lamp.flux = 1e6;
  return lamp;
}

TEST(LightPlane, FluxDoesNotDependOnThePlaceWithinAPixel) {
  constexpr double kRelative = 1e-4;
  const Psf psf({}, 2000.0);
  LightPlane plane(kSize_px, kSize_px, psf, 0.001, 0.0);
  Random random(11);
  for (const double disc_px : {0.01, 0.4, 1.7, 5.0, 14.0, 40.0}) {
    plane.clear();
    plane.add(lamp_at(200.0, 200.0, disc_px));
    const double centred = moments_of(plane, 1e9, {200.0, 200.0}).flux;
    for (int trial = 0; trial < 6; ++trial) {
      plane.clear();
      plane.add(
          lamp_at(200.0 + random.uniform(-0.5, 0.5), 200.0 + random.uniform(-0.5, 0.5), disc_px));
      const double shifted = moments_of(plane, 1e9, {200.0, 200.0}).flux;
      EXPECT_NEAR(shifted / centred, 1.0, kRelative) << "disc " << disc_px;
    }
  }
}

}  // namespace
}  // namespace vildar
