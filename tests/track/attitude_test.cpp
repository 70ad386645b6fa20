#include "track/attitude.h"

#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "core/random.h"

namespace vildar {
namespace {

constexpr double kFocal_px = 1000.0;

// Lights that stand, seen by a camera that turns as told; rotations written out in full.
struct Shaken {
  std::vector<Eigen::Vector3d> rays;  ///< camera axes at rest, forward 1
  double sigma_px = 0.1;
  Random random{11};
  Attitude attitude{kFocal_px};

  Eigen::Vector2d seen_px(const Eigen::Vector3d& ray, const Eigen::Vector3d& rotation_rad) {
    const double angle_rad = rotation_rad.norm();
    const Eigen::Vector3d turned =
        angle_rad > 0.0
            ? Eigen::Vector3d(Eigen::AngleAxisd(-angle_rad, rotation_rad / angle_rad) * ray)
            : ray;
    return kFocal_px * turned.hnormalized() +
           sigma_px * Eigen::Vector2d(random.normal(), random.normal());
  }
  void frame(std::int64_t frame, const Eigen::Vector3d& rotation_rad) {
    for (std::size_t i = 0; i < rays.size(); ++i)
      attitude.add(i, {{frame, seen_px(rays[i], rotation_rad), sigma_px}});
    attitude.solve(frame);
  }
};

const std::vector<Eigen::Vector3d> kThree{{-0.3, -0.1, 1.0}, {0.25, -0.15, 1.0}, {0.1, -0.02, 1.0}};

Eigen::Vector3d shaken_rad(std::int64_t frame) {
  const double t = static_cast<double>(frame);
  return {2e-3 * std::sin(0.61 * t), 1.5e-3 * std::sin(0.37 * t + 1.0),
          1e-3 * std::sin(0.53 * t + 2.0)};
}

TEST(Attitude, TurnsAreFoundWithTheSigmaTheyState) {
  Shaken shaken{kThree};
  double chi2 = 0.0;
  int count = 0;
  for (int i = 0; i < 3000; ++i) {
    shaken.frame(i, shaken_rad(i));
    if (i < 500) continue;  // until the references have settled
    const auto turn = shaken.attitude.at(i);
    ASSERT_TRUE(turn);
    const Eigen::Vector3d error_rad = turn->rotation_rad - shaken_rad(i);
    chi2 += error_rad.dot(turn->covariance.inverse() * error_rad);
    ++count;
    // No drift: the last is as good as the first.
    EXPECT_LT(error_rad.head<2>().norm(), 6.0 * 0.1 / kFocal_px) << i;
  }
  // Chi-square of three degrees of freedom; references of 250 frames add a little.
  EXPECT_NEAR(chi2 / count / 3.0, 1.0, 0.15);
}

TEST(Attitude, ALateLightJoinsWithoutAStep) {
  Shaken shaken{{kThree[0], kThree[1]}};
  for (int i = 0; i < 300; ++i) shaken.frame(i, shaken_rad(i));
  // It was followed for a while before it was known to stand; the camera stood askew meanwhile.
  const Eigen::Vector3d askew_rad(4e-3, -3e-3, 0.0);
  std::vector<StaticSighting> past;
  for (int i = 300; i < 330; ++i) {
    shaken.frame(i, askew_rad);
    past.push_back({i, shaken.seen_px(kThree[2], askew_rad), 0.1});
  }
  shaken.attitude.add(7, past);
  shaken.attitude.solve(329);
  shaken.rays = {};
  for (int i = 330; i < 340; ++i) {
    shaken.attitude.add(7, {{i, shaken.seen_px(kThree[2], Eigen::Vector3d::Zero()), 0.1}});
    shaken.attitude.solve(i);
    const auto turn = shaken.attitude.at(i);
    ASSERT_TRUE(turn);
    EXPECT_LT(turn->rotation_rad.head<2>().norm(), 1e-3);  // of the 5 mrad that it stood askew
  }
}

TEST(Attitude, OneLightLeavesTheTurnAboutItselfOpen) {
  Shaken shaken{{{0.0, -0.1, 1.0}}};
  for (int i = 0; i < 400; ++i) shaken.frame(i, {shaken_rad(i).x(), shaken_rad(i).y(), 0.0});
  const auto turn = shaken.attitude.at(399);
  ASSERT_TRUE(turn);
  EXPECT_LT(std::abs(turn->rotation_rad.x() - shaken_rad(399).x()), 5e-4);
  // As much as the other axes move: nothing is said of it.
  EXPECT_GT(std::sqrt(turn->covariance(2, 2)), 5e-4);
}

TEST(Attitude, ACameraThatStandsStillIsLeftAlone) {
  Shaken shaken{kThree};
  for (int i = 0; i < 500; ++i) {
    shaken.frame(i, Eigen::Vector3d::Zero());
    EXPECT_FALSE(shaken.attitude.at(i)) << i;
  }
}

TEST(Attitude, TwoLightsWhoseCentresWanderABitAreNoShaking) {
  Shaken shaken{{kThree[0], kThree[1]}};
  shaken.sigma_px = 0.05;
  const std::vector<Eigen::Vector3d> at_rest = shaken.rays;
  constexpr double kSlow = 0.95, kWander_px = 0.15;
  std::vector<Eigen::Vector2d> wander_px(2, Eigen::Vector2d::Zero());
  for (int i = 0; i < 500; ++i) {
    for (std::size_t k = 0; k < 2; ++k) {
      wander_px[k] = kSlow * wander_px[k] +
                     std::sqrt(1.0 - kSlow * kSlow) * kWander_px *
                         Eigen::Vector2d(shaken.random.normal(), shaken.random.normal());
      shaken.rays[k] = at_rest[k];
      shaken.rays[k].head<2>() += wander_px[k] / kFocal_px;
    }
    shaken.frame(i, Eigen::Vector3d::Zero());
    EXPECT_FALSE(shaken.attitude.at(i)) << i;
  }
}

TEST(Attitude, ACodersNewPictureIsNoShaking) {
  // Every two seconds the lights are drawn anew, a part of a pixel off; between they stay.
  Shaken shaken{{kThree[0], kThree[1]}};
  shaken.sigma_px = 0.001;
  for (int i = 0; i < 600; ++i) {
    if (i % 50 == 0)
      for (std::size_t k = 0; k < 2; ++k)
        shaken.rays[k].head<2>() =
            kThree[k].head<2>() +
            0.5 / kFocal_px * Eigen::Vector2d(shaken.random.normal(), shaken.random.normal());
    shaken.frame(i, Eigen::Vector3d::Zero());
    EXPECT_FALSE(shaken.attitude.at(i)) << i;
  }
}

TEST(Attitude, ALightThatMovesAfterAllIsOutvoted) {
  Shaken shaken{kThree};
  shaken.rays.push_back({-0.1, -0.2, 1.0});
  for (int i = 0; i < 600; ++i) {
    shaken.rays[3].x() += 1e-4;  // three pixels a second at 30 Hz
    shaken.frame(i, shaken_rad(i));
    const auto turn = shaken.attitude.at(i);
    if (i < 300 || !turn) continue;
    EXPECT_LT((turn->rotation_rad - shaken_rad(i)).head<2>().norm(), 1e-3) << i;
  }
}

TEST(Attitude, FramesWithoutALightMayTurnAsTheOthersDo) {
  Shaken shaken{kThree};
  for (int i = 0; i < 400; ++i) shaken.frame(i, shaken_rad(i));
  shaken.attitude.solve(400);
  const auto turn = shaken.attitude.at(400);
  ASSERT_TRUE(turn);
  EXPECT_TRUE(turn->rotation_rad.isZero());
  // The amplitudes of the sines over the root of two.
  const Eigen::Vector3d moved_rad = Eigen::Vector3d(2e-3, 1.5e-3, 1e-3) / std::sqrt(2.0);
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_NEAR(std::sqrt(turn->covariance(axis, axis)) / moved_rad[axis], 1.0, 0.1) << axis;
}

TEST(Attitude, ForgottenFramesTellNothing) {
  Shaken shaken{kThree};
  for (int i = 0; i < 100; ++i) shaken.frame(i, shaken_rad(i));
  const double told_rad = std::sqrt(shaken.attitude.at(60)->covariance(0, 0));
  shaken.attitude.forget_before(61);
  EXPECT_GT(std::sqrt(shaken.attitude.at(60)->covariance(0, 0)), 3.0 * told_rad);
  EXPECT_LT(std::sqrt(shaken.attitude.at(61)->covariance(0, 0)), 2.0 * told_rad);
}

}  // namespace
}  // namespace vildar
