#include "detect/rim_fit.h"

#include <gtest/gtest.h>

#include <array>

#include "core/random.h"
#include "scene.h"

namespace vildar {
namespace {

TEST(RimFit, FindsADiscHalfHiddenByAnother) {
  constexpr int kTrials = 40;
  // Rms of 2 * 40 values: 8 % standard error. The stated sigma may be up to twice too wide, since
  // rays that share a pixel do not count in full.
  Random random(9);
  for (const double radius_px : {4.0, 9.0, 16.0}) {
    double square = 0.0;
    for (int trial = 0; trial < kTrials; ++trial) {
      const double u = 40.0 + random.uniform(), v = 40.0 + random.uniform();
      scene::Picture picture(110, 80, 0.0);
      picture.add_disc(u, v, radius_px, 5.0);
      picture.add_disc(u + 1.6 * radius_px, v, radius_px, 5.0);
      const Frame frame = picture.frame8();
      const std::array<Eigen::Vector2d, 1> hidden = {Eigen::Vector2d::UnitX()};
      const Eigen::Vector2d start_px(u + 0.1 * radius_px, v - 0.5);
      const auto circle = fit_rim(frame.luma, 250, start_px, hidden);
      ASSERT_TRUE(circle) << radius_px;
      EXPECT_NEAR(circle->radius_px, radius_px, 0.8);
      EXPECT_LT(circle->centre_sigma_px, 0.4);
      square += (circle->centre_px - Eigen::Vector2d(u, v)).squaredNorm() /
                std::pow(circle->centre_sigma_px, 2);
    }
    const double rms = std::sqrt(square / (2 * kTrials));
    EXPECT_LT(rms, 1.3) << radius_px;
    EXPECT_GT(rms, 0.4) << radius_px;
  }
}

TEST(RimFit, RefusesWhatIsNoCircle) {
  scene::Picture picture(120, 40, 0.0);
  for (int v = 15; v < 22; ++v)
    for (int u = 20; u < 100; ++u) picture.at(u, v) = 5.0;
  const Frame frame = picture.frame8();
  EXPECT_FALSE(fit_rim(frame.luma, 250, {60.0, 18.0}, {}));
  // A plane clipped all over shows no rim.
  const Frame full = scene::Picture(40, 40, 5.0).frame8();
  EXPECT_FALSE(fit_rim(full.luma, 250, {20.0, 20.0}, {}));
}

}  // namespace
}  // namespace vildar
