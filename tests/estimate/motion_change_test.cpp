#include "estimate/motion_change.h"

#include <cmath>

#include <gtest/gtest.h>

#include "estimate/mixture.h"
#include "simulated_pass.h"

namespace vildar {
namespace {

std::vector<Trajectory> trajectories_of(const simulated::Vehicle& vehicle, const Site& site,
                                        double seen_s, Random& random) {
  std::vector<std::string> warnings;
  const VehicleTrack track = simulated::track_of(vehicle, site, {.to_s = seen_s}, random);
  return std::get<std::vector<Trajectory>>(
      fit_trajectories(track, Camera(*site.camera), site, warnings));
}

Site surveyed_site() {
  Site site = simulated::mast_site(4.0);
  site.lamps.height_m->std = 0.01;
  return site;
}

TEST(AccelerationStep, WayIsTheIntegralOfWhatLiesBeyond) {
  for (const double step_s : {-0.7, 0.4})
    for (const double at_s : {-1.5, -0.5, 0.0, 0.3, 1.1}) {
      const AccelerationStep step{step_s, 1.0};
      constexpr double kSmall_s = 1e-6;
      const double slope = (step.way(at_s + kSmall_s) - step.way(at_s - kSmall_s)) / (2 * kSmall_s);
      EXPECT_NEAR(slope, step.beyond_s(at_s), 1e-6);
      // Nothing on the side of the reference time.
      const bool near = at_s * step_s <= 0.0 || std::abs(at_s) < std::abs(step_s);
      EXPECT_EQ(step.way(at_s) == 0.0, near);
    }
}

TEST(MotionChange, ABrakingInViewIsFollowedFromFrameToFrame) {
  const Site site = surveyed_site();
  Random random(3);
  simulated::Vehicle vehicle;
  vehicle.speed_mps = 20.0;
  vehicle.height_m = 0.65;
  vehicle.separation_m = 1.2;
  vehicle.changes = {{1.0, -4.0}};
  const auto trajectories = trajectories_of(vehicle, site, 2.2, random);
  for (double t_s = 0.1; t_s < 2.2; t_s += 0.1) {
    const MotionState state = mixed_state(trajectories, t_s);
    EXPECT_LT(std::abs(state.over_ground_mps - vehicle.speed_at_mps(t_s)),
              4.0 * state.speed_std_mps)
        << t_s;
    EXPECT_LT(state.speed_std_mps, 1.0) << t_s;
    EXPECT_LT(std::abs(state.range_m - vehicle.along_at_m(t_s)), 4.0 * state.range_std_m) << t_s;
  }
}

// Where it is seen best, and near the camera; far away the onset of a change goes unseen.
TEST(MotionChange, SpeedsAlongTheTrackLieInTheirIntervals) {
  constexpr int kTrials = 150;
  const Site site = surveyed_site();
  for (const double at_share : {0.5, 0.9}) {
    Random random(8);
    int inside = 0;
    for (int i = 0; i < kTrials; ++i) {
      simulated::Vehicle vehicle;
      vehicle.speed_mps = random.uniform(15.0, 30.0);
      vehicle.lateral_m = random.normal(-4.0, 0.3);
      vehicle.height_m = random.normal(0.65, 0.01);
      vehicle.separation_m = random.normal(1.2, 0.15);
      const double seen_s = 40.0 / vehicle.speed_mps;
      const double change_s = random.uniform(0.2, 0.8) * seen_s;
      vehicle.changes = {{change_s, random.normal(0.0, 2.5)}};
      const double at_s = at_share * seen_s;
      const MotionState state = mixed_state(trajectories_of(vehicle, site, seen_s, random), at_s);
      inside +=
          std::abs(state.over_ground_mps - vehicle.speed_at_mps(at_s)) < 1.96 * state.speed_std_mps;
    }
    EXPECT_GE(inside, 0.95 * kTrials - 3.0 * std::sqrt(0.95 * 0.05 * kTrials)) << at_share;
  }
}

}  // namespace
}  // namespace vildar
