#include "synth/light_plane.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/quantity.h"
#include "core/random.h"

namespace vildar {
namespace {

constexpr int kSize_px = 240;
const Eigen::Vector2d kMiddle_px(120.0, 120.0);

struct Moments {
  double flux = 0.0;
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  double u_variance_px2 = 0.0;
};

Moments moments_of(const LightPlane& plane, double reach_px) {
  Moments sum;
  double square = 0.0;
  for (int v = 0; v < kSize_px; ++v)
    for (int u = 0; u < kSize_px; ++u) {
      const Eigen::Vector2d pixel_px(u, v);
      if ((pixel_px - kMiddle_px).norm() > reach_px) continue;
      const double light = plane.at(u, v);
      sum.flux += light;
      sum.centre_px += light * (pixel_px - kMiddle_px);
      square += light * (u - kMiddle_px.x()) * (u - kMiddle_px.x());
    }
  sum.centre_px /= sum.flux;
  sum.u_variance_px2 = square / sum.flux - sum.centre_px.x() * sum.centre_px.x();
  return sum;
}

LampImage lamp_at(const Eigen::Vector2d& centre_px, double disc_px) {
  LampImage lamp;
  lamp.centre_px = centre_px;
  lamp.disc_radius_px = disc_px;
  lamp.flux = 1e6;
  return lamp;
}

TEST(LightPlane, FluxDoesNotDependOnThePlaceWithinAPixel) {
  constexpr double kRelative = 1e-4;
  const Psf psf({}, 800.0);
  LightPlane plane(kSize_px, kSize_px, psf, 0.001, 0.0);
  Random random(11);
  for (const double disc_px : {0.01, 0.4, 1.7, 5.0, 14.0, 30.0}) {
    plane.clear();
    plane.add(lamp_at(kMiddle_px, disc_px));
    const double centred = moments_of(plane, 1e9).flux;
    for (int trial = 0; trial < 3; ++trial) {
      const Eigen::Vector2d shift_px(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5));
      plane.clear();
      plane.add(lamp_at(kMiddle_px + shift_px, disc_px));
      EXPECT_NEAR(moments_of(plane, 1e9).flux / centred, 1.0, kRelative) << "disc " << disc_px;
    }
  }
}

TEST(LightPlane, AllLightOfACoreWithoutWingsIsThere) {
  const Psf psf({0.5, 0.0, 2.0, 2.5}, 800.0);  // the sharpest core allowed
  LightPlane plane(kSize_px, kSize_px, psf, 0.001, 0.0);
  plane.add(lamp_at(kMiddle_px + Eigen::Vector2d(0.31, -0.17), 3.3));
  EXPECT_NEAR(moments_of(plane, 1e9).flux / 1e6, 1.0, 1e-4);
}

// Within r of a point: the gaussian whole, of the wing 1 - (1 + r^2 / a^2)^(1 - q / 2).
TEST(LightPlane, FluxIsTheClosedFormHoweverBright) {
  constexpr double kRelative = 1e-3;
  constexpr double kFullWell_e = 10'000.0;
  constexpr int kWide_px = 700;
  const Psf psf({}, 1500.0);
  LightPlane plane(kWide_px, kWide_px, psf, 0.001, 0.0);
  const Eigen::Vector2d middle_px(350.3, 349.6);
  for (const double saturation : {2.0, 20.0, 200.0, 2000.0})
    for (const double disc_px : {0.3, 4.0}) {
      // The brightest pixel of a narrow lamp holds about flux / (2 pi sigma^2 + pi r^2).
      LampImage lamp;
      lamp.centre_px = middle_px;
      lamp.disc_radius_px = disc_px;
      lamp.flux = saturation * kFullWell_e * kPi * (2.0 * 0.81 + disc_px * disc_px);
      plane.clear();
      plane.add(lamp);
      double sum = 0.0;
      for (int v = 0; v < kWide_px; ++v)
        for (int u = 0; u < kWide_px; ++u)
          if ((Eigen::Vector2d(u, v) - middle_px).norm() < 300.0) sum += plane.at(u, v);
      const double wing = 1.0 - std::pow(1.0 + 300.0 * 300.0 / 4.0, -0.25);
      EXPECT_NEAR(sum / lamp.flux / (0.97 + 0.03 * wing), 1.0, kRelative)
          << saturation << " x full well, disc " << disc_px;
    }
}

TEST(LightPlane, AStreakHoldsItsFluxAndItsLength) {
  const Psf psf({}, 800.0);
  LightPlane plane(kSize_px, kSize_px, psf, 0.001, 0.0);
  LampImage lamp = lamp_at(kMiddle_px + Eigen::Vector2d(0.3, -0.2), 1.0);
  lamp.streak_px = 12.0;
  plane.add(lamp);
  const Moments moments = moments_of(plane, 1e9);
  EXPECT_NEAR(moments.flux / 1e6, 1.0, 1e-3);  // cut at four sigmas
  EXPECT_LT((moments.centre_px - Eigen::Vector2d(0.3, -0.2)).norm(), 0.02);
  EXPECT_NEAR(moments.u_variance_px2, 0.81 + 0.25 + 1.0 / 12.0, 0.02);
  double upright = 0.0;
  for (int v = 0; v < kSize_px; ++v)
    for (int u = 0; u < kSize_px; ++u) upright += plane.at(u, v) * (v - 119.8) * (v - 119.8);
  EXPECT_NEAR(upright / moments.flux, 144.0 + 0.81 + 0.25 + 1.0 / 12.0, 0.5);
}

TEST(LightPlane, AQuadHoldsItsAreaOfLight) {
  const Psf psf({}, 800.0);
  LightPlane plane(kSize_px, kSize_px, psf, 0.001, 0.0);
  QuadImage quad;
  quad.corners_px = {Eigen::Vector2d(90.2, 100.4), {140.7, 95.1}, {138.3, 141.9}, {92.6, 136.2}};
  quad.light = 50.0;
  plane.add(quad);
  double twice_area_px2 = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d &a = quad.corners_px[i], &b = quad.corners_px[(i + 1) % 4];
    twice_area_px2 += a.x() * b.y() - b.x() * a.y();
  }
  // The blur of the edges conserves light but for the corners that are not square.
  EXPECT_NEAR(moments_of(plane, 1e9).flux / (50.0 * 0.5 * twice_area_px2), 1.0, 1e-3);
  EXPECT_NEAR(plane.at(115, 118), 50.0, 1e-3);
  EXPECT_NEAR(plane.at(60, 118), 0.0, 1e-6);
}

TEST(LightPlane, CentroidFollowsTheLamp) {
  constexpr double kTolerance_px = 0.002;
  const Psf psf({}, 800.0);
  LightPlane plane(kSize_px, kSize_px, psf, 0.001, 0.0);
  for (const double disc_px : {0.01, 1.2, 6.0})
    for (const double shift : {-0.45, -0.2, 0.1, 0.37, 0.5}) {
      const Eigen::Vector2d shift_px(shift, -0.6 * shift);
      plane.clear();
      plane.add(lamp_at(kMiddle_px + shift_px, disc_px));
      // A window fixed to the pixels cuts the wings off unevenly; taking the middle of the wings to
      // be still, only the rest of the light moves.
      const Psf core_only({0.9, 0.0, 2.0, 2.5}, 800.0);
      LightPlane core(kSize_px, kSize_px, core_only, 0.001, 0.0);
      core.add(lamp_at(kMiddle_px + shift_px, disc_px));
      EXPECT_LT((moments_of(core, 1e9).centre_px - shift_px).norm(), kTolerance_px)
          << "disc " << disc_px << " shift " << shift;
      // With wings: mirrored shift, mirrored picture.
      const Eigen::Vector2d seen_px = moments_of(plane, 119.5).centre_px;
      plane.clear();
      plane.add(lamp_at(kMiddle_px - shift_px, disc_px));
      EXPECT_LT((moments_of(plane, 119.5).centre_px + seen_px).norm(), kTolerance_px);
    }
}

TEST(LightPlane, MotionSmearsByTheWayGoneWhileExposed) {
  const Psf psf({0.9, 0.0, 2.0, 2.5}, 800.0);
  constexpr double kExposure_s = 0.01;
  LightPlane plane(kSize_px, kSize_px, psf, kExposure_s, 0.0);
  LampImage lamp = lamp_at(kMiddle_px, 1.5);
  plane.add(lamp);
  const double still_px2 = moments_of(plane, 1e9).u_variance_px2;
  // The variance of a disc is radius^2 / 4, and of a pixel 1/12.
  EXPECT_NEAR(still_px2, 0.81 + 1.5 * 1.5 / 4.0 + 1.0 / 12.0, 2e-3);
  lamp.velocity_px_per_s = {600.0, 0.0};
  plane.clear();
  plane.add(lamp);
  const Moments smeared = moments_of(plane, 1e9);
  EXPECT_NEAR(smeared.u_variance_px2 - still_px2, 6.0 * 6.0 / 12.0, 0.02);
  EXPECT_NEAR(smeared.centre_px.x(), 0.0, 1e-3);
}

TEST(LightPlane, RollingShutterShearsAMovingLamp) {
  const Psf psf({0.9, 0.0, 2.0, 2.5}, 800.0);
  constexpr double kRow_s = 1e-4;
  LightPlane plane(kSize_px, kSize_px, psf, 1e-5, kRow_s);
  LampImage lamp = lamp_at(kMiddle_px, 8.0);
  lamp.velocity_px_per_s = {1000.0, 0.0};
  plane.add(lamp);
  // Ten rows further down the lamp has gone 10 * 1e-4 s * 1000 px/s = 1 px to the right.
  const auto row_centre_px = [&](int v) {
    double light = 0.0, moment = 0.0;
    for (int u = 0; u < kSize_px; ++u) {
      light += plane.at(u, v);
      moment += plane.at(u, v) * u;
    }
    return moment / light;
  };
  EXPECT_NEAR(row_centre_px(125), 120.5, 2e-3);
  EXPECT_NEAR(row_centre_px(115), 119.5, 2e-3);
}

TEST(LightPlane, ClearLeavesNothing) {
  const Psf psf({}, 800.0);
  LightPlane plane(kSize_px, kSize_px, psf, 0.001, 0.0);
  plane.add(lamp_at({3.0, 238.0}, 5.0));
  plane.add(lamp_at({-30.0, 100.0}, 20.0));
  EXPECT_GT(moments_of(plane, 1e9).flux, 0.0);
  plane.clear();
  for (int v = 0; v < kSize_px; ++v)
    for (int u = 0; u < kSize_px; ++u) ASSERT_EQ(plane.at(u, v), 0.0);
}

}  // namespace
}  // namespace vildar
