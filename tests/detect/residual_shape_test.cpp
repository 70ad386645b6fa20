#include "detect/residual_shape.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/random.h"

namespace vildar {
namespace {

int place(const Eigen::Vector2d& at, double share_of_reach) {
  return ResidualShape::place_of(0, at.cast<float>(),
                                 static_cast<float>(share_of_reach * ResidualShape::kRings));
}

/// Verdict on a disc of pixels of unit noise with a mean that depends on the place.
template <class Mean>
ResidualShape::Verdict verdict_on(std::uint64_t seed, double noise_share, const Mean& mean) {
  constexpr int kReach_px = 14;
  Random random(seed);
  ResidualShape shape(1);
  for (int v = -kReach_px; v <= kReach_px; ++v)
    for (int u = -kReach_px; u <= kReach_px; ++u) {
      const Eigen::Vector2d at(u, v);
      const double ring = at.norm() / kReach_px;
      if (ring >= 1.0) continue;
      const double residual = random.normal(0.0, 1.0) + mean(at, ring);
      shape.add(place(at, ring), static_cast<float>(residual), static_cast<float>(noise_share));
    }
  return shape.verdict(4.0, 1.0);
}

TEST(ResidualShape, NoiseHasNone) {
  constexpr int kTrials = 400;
  int shaped = 0, round = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const auto verdict = verdict_on(static_cast<std::uint64_t>(trial), 1.0,
                                    [](const Eigen::Vector2d&, double) { return 0.0; });
    shaped += verdict.shaped;
    round += verdict.round;
    EXPECT_NEAR(verdict.chi2_per_dof, 1.0, 0.3);  // five sigmas of 610 pixels
  }
  // Nothing was fitted, so that 24 places count as 19 degrees of freedom.
  EXPECT_LT(shaped, 0.15 * kTrials);
  EXPECT_LT(round, 0.3 * kTrials);
}

TEST(ResidualShape, WhatDoesNotCountChangesNothing) {
  Random random(7);
  ResidualShape shape(1), same(1);
  for (int i = 0; i < 500; ++i) {
    const int at = static_cast<int>(
        random.uniform(0.0, ResidualShape::kRings * ResidualShape::kQuarters - 1e-9));
    const auto residual = static_cast<float>(random.normal(0.0, 1.0));
    shape.add(at, residual, 1.0F);
    same.add(at, residual, 1.0F);
    same.add(ResidualShape::kRings * ResidualShape::kQuarters, 100.0F, 1.0F);
  }
  constexpr double kSingle = 1e-5;
  EXPECT_NEAR(same.verdict(4.0, 1.0).chi2_per_dof, shape.verdict(4.0, 1.0).chi2_per_dof, kSingle);
  EXPECT_NEAR(same.verdict(4.0, 1.0).shape, shape.verdict(4.0, 1.0).shape, 100.0 * kSingle);
}

TEST(ResidualShape, TellsWhatIsRoundFromWhatLiesToOneSide) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const auto round = verdict_on(
        seed, 1.0, [](const Eigen::Vector2d&, double ring) { return std::cos(6.0 * ring); });
    EXPECT_TRUE(round.shaped && round.round);
    const auto half = verdict_on(
        seed, 1.0, [](const Eigen::Vector2d& at, double) { return at.x() > 3.0 ? 1.5 : -0.5; });
    EXPECT_TRUE(half.shaped && half.quarters_differ);
    EXPECT_FALSE(half.round);
  }
}

TEST(ResidualShape, PixelsThatErrTogetherMayHaveAShape) {
  const auto half = [](const Eigen::Vector2d& at, double) { return at.x() > 3.0 ? 0.15 : -0.05; };
  int own = 0, common = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    own += verdict_on(seed, 1.0, half).shaped;
    common += verdict_on(seed, 0.1, half).shaped;
  }
  EXPECT_LT(common, own);
}

TEST(ResidualShape, PixelsThatErrByPatchesHaveNone) {
  constexpr int kTrials = 100, kReach_px = 14;
  int taken_alone = 0, by_patches = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    Random random(static_cast<std::uint64_t>(trial));
    ResidualShape alone(1), patches(1, 4.0);
    for (int v = -kReach_px; v < kReach_px; v += 2)
      for (int u = -kReach_px; u < kReach_px; u += 2) {
        const double error = random.normal(0.0, 1.0);
        for (const Eigen::Vector2d& within : {Eigen::Vector2d(0, 0), Eigen::Vector2d(1, 0),
                                              Eigen::Vector2d(0, 1), Eigen::Vector2d(1, 1)}) {
          const Eigen::Vector2d at = Eigen::Vector2d(u, v) + within;
          const double ring = at.norm() / kReach_px;
          if (!(ring < 1.0)) continue;
          for (ResidualShape* shape : {&alone, &patches})
            shape->add(place(at, ring), static_cast<float>(error), 1.0F);
        }
      }
    taken_alone += alone.verdict(4.0, 1.0).shaped;
    by_patches += patches.verdict(4.0, 1.0).shaped;
  }
  EXPECT_GT(taken_alone, 0.9 * kTrials);
  EXPECT_LT(by_patches, 0.2 * kTrials);
}

}  // namespace
}  // namespace vildar
