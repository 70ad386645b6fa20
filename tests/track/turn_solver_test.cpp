#include "track/turn_solver.h"

#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include "drive_past_lamps.h"

namespace vildar {
namespace {

using drive::Drive;
using drive::TurnAt;

// Errors of the frames in which a light was seen, and of their mean.
struct Score {
  double chi2 = 0.0, mean_chi2 = 0.0, square_rad2 = 0.0;  // per axis
  double frames = 0.0, trials = 0.0;

  void add(const TurnProblem& problem, const TurnSolution& found, const TurnAt& truth) {
    std::vector<char> lit(problem.frames, 0);
    for (const PassedLight& one : problem.sightings) lit[one.frame] = 1;
    std::vector<std::pair<std::size_t, Eigen::Vector3d>> errors_rad;
    Eigen::Vector3d mean_rad = Eigen::Vector3d::Zero();
    for (std::size_t frame = 0; frame < problem.frames; ++frame) {
      if (!lit[frame]) continue;
      errors_rad.emplace_back(frame, found.rotation_rad[frame] - truth(frame));
      mean_rad += errors_rad.back().second;
    }
    mean_rad /= static_cast<double>(errors_rad.size());
    for (const auto& [frame, error_rad] : errors_rad) {
      const Eigen::Vector3d own_rad = error_rad - mean_rad;
      chi2 += own_rad.dot(found.covariance[frame].inverse() * own_rad) / 3.0;
      square_rad2 += own_rad.head<2>().squaredNorm() / 2.0;
      frames += 1.0;
    }
    mean_chi2 += mean_rad.cwiseQuotient(found.mean_std_rad).head<2>().squaredNorm() / 2.0;
    trials += 1.0;
  }
  double rms_rad() const { return std::sqrt(square_rad2 / frames); }
};

enum class Shake { swings, independent, wanders };

struct Case {
  int lights = 6;
  double curvature_per_m = 0.0;
  double told_speed_mps = drive::kSpeed_mps;
  bool with_vehicle = false;
  Shake shake = Shake::swings;
};

TurnAt shake_of(Shake shake, Random& random) {
  switch (shake) {
    case Shake::swings: return drive::swinging(random, 0.005);
    case Shake::independent: return drive::wandering(random, 0.005, 0.0);
    case Shake::wanders: return drive::wandering(random, 0.005, 0.9);
  }
  return {};
}

Score score_of(const Case& one) {
  constexpr int kTrials = 40;
  Random random(20260107);
  Score score;
  for (int trial = 0; trial < kTrials; ++trial) {
    Drive drive;
    drive.told_speed_mps = one.told_speed_mps;
    drive.curvature_per_m = one.curvature_per_m;
    drive.lights = drive::lamps_beside_the_road(random, one.lights, one.curvature_per_m);
    // Brakes by 4 m/s^2: at a steady speed it would be seen as a point that stands nearer.
    if (one.with_vehicle)
      drive.lights.push_back([](double time_s) {
        return Eigen::Vector3d(120.0 - 12.0 * time_s + 2.0 * time_s * time_s, 3.5, 2.6);
      });
    drive.turn = shake_of(one.shake, random);
    const TurnProblem problem = drive.seen(random);
    if (const auto found = solve_turns(problem))
      score.add(problem, *found, drive.turn);
    else
      ADD_FAILURE() << trial;
  }
  return score;
}

// One coordinate of one light is good to 0.28 mrad; the shake is of 5 mrad up and down.
constexpr double kTold_rad = 3.5e-4;
// Forty trials, each with two means: four sigmas of their chi-square, and the same for the frames
// of a trial, whose errors have about as many parts. A slow shake may be less well known than that.
constexpr double kMostChi2 = 1.65;

void expect_told(const Score& score, double most_rad = kTold_rad) {
  EXPECT_LT(score.rms_rad(), most_rad);
  EXPECT_LT(score.chi2 / score.frames, kMostChi2);
  EXPECT_LT(score.mean_chi2 / score.trials, kMostChi2);
}

TEST(TurnSolver, TurnsAreFoundWithTheSigmaTheyState) {
  const Score score = score_of({});
  expect_told(score);
  EXPECT_GT(score.chi2 / score.frames, 0.4);
}

TEST(TurnSolver, SigmasHoldForTurnsOfAnyKind) {
  expect_told(score_of({.shake = Shake::independent}));
  expect_told(score_of({.shake = Shake::wanders}), 2.0 * kTold_rad);
}

TEST(TurnSolver, OneLightTellsTurnsUpToItsOwnPlace) {
  expect_told(score_of({.lights = 1}), 2.0 * kTold_rad);
}

TEST(TurnSolver, OnABend) { expect_told(score_of({.curvature_per_m = 1.0 / 200.0})); }

// All places are as much farther.
TEST(TurnSolver, AnOwnSpeedThatIsOffDoesNoHarm) { expect_told(score_of({.told_speed_mps = 16.0})); }

TEST(TurnSolver, ALightThatMovesIsOutvoted) { expect_told(score_of({.with_vehicle = true})); }

TEST(TurnSolver, FramesWithoutALightMayTurnAsTheOthersDo) {
  Random random(5);
  Drive drive;
  drive.lights = drive::lamps_beside_the_road(random, 6);
  drive.turn = drive::swinging(random, 0.005);
  TurnProblem problem = drive.seen(random);
  std::erase_if(problem.sightings, [](const PassedLight& one) { return one.frame == 50; });
  const auto found = solve_turns(problem);
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->rotation_rad[50].isZero());
  EXPECT_NEAR(std::sqrt(found->covariance[50](0, 0)), found->std_rad[0], 1e-12);
  EXPECT_NEAR(found->std_rad[0], 0.005, 0.002);
}

TEST(TurnSolver, NoLightTellsNothing) {
  Random random(3);
  EXPECT_FALSE(solve_turns(Drive{}.seen(random)));
}

}  // namespace
}  // namespace vildar
