#include "calib/site/turned_camera.h"

#include <gtest/gtest.h>

#include "simulated_site.h"

namespace vildar {
namespace {

// Passes of one mounting; its camera is turned to the left by `turn_rad` from what is true.
std::vector<VehicleTrack> run_of(simulated::TrueSite truth, double turn_rad, int passes,
                                 double along_road_std_rad, Random& random) {
  const double yaw_rad = truth.site.camera->yaw_rad.mean + turn_rad;
  std::vector<VehicleTrack> run;
  for (int i = 0; i < passes; ++i) {
    // A vehicle that drives across the road by an angle is seen as one along it by a turned camera.
    truth.site.camera->yaw_rad.mean = yaw_rad + random.normal(0.0, along_road_std_rad);
    run.push_back(simulated::passes_of(truth, 1, 15.0, random).front().track);
    run.back().id = i + 1;
  }
  return run;
}

struct Mounting {
  Site stated = simulated::roughly_known_site(4.0, 0.01);
  Random random;
  simulated::TrueSite truth;

  explicit Mounting(std::uint64_t seed)
      : random(seed), truth(simulated::true_site(stated, random)) {}
};

TEST(TurnedCamera, RunsOfTwoToFourPassesTellIt) {
  const double turn_rad = radians_from_degrees(0.2);
  for (const auto& [one, other] : {std::pair{2, 2}, {3, 4}, {4, 4}, {8, 2}}) {
    Mounting mounting(11);
    const std::vector runs{run_of(mounting.truth, 0.0, one, 0.0, mounting.random),
                           run_of(mounting.truth, turn_rad, other, 0.0, mounting.random)};
    const auto turned = turned_camera(runs, mounting.stated);
    ASSERT_TRUE(turned) << one << " and " << other;
    EXPECT_EQ(turned->by_one.key, "camera.yaw_deg");
    EXPECT_EQ(turned->one, 1u);
    EXPECT_EQ(turned->other, 0u);
    const double found_rad = turned->by_one.after.mean - turned->by_other.after.mean;
    EXPECT_NEAR(found_rad, turn_rad, 0.2 * turn_rad);
  }
}

TEST(TurnedCamera, VehiclesThatDifferAreNoTurn) {
  // Vehicles that drive half a degree from along the road, some: two of a run by chance alike.
  const double across_rad = radians_from_degrees(0.5);
  for (std::uint64_t seed = 1; seed <= 25; ++seed) {
    Mounting mounting(seed);
    std::vector<std::vector<VehicleTrack>> runs;
    for (const int passes : {2, 3, 2})
      runs.push_back(run_of(mounting.truth, 0.0, passes, across_rad, mounting.random));
    EXPECT_FALSE(turned_camera(runs, mounting.stated)) << seed;
  }
}

TEST(TurnedCamera, OnePassIsNotJudged) {
  Mounting mounting(3);
  const std::vector runs{run_of(mounting.truth, 0.0, 6, 0.0, mounting.random),
                         run_of(mounting.truth, 0.01, 1, 0.0, mounting.random)};
  EXPECT_FALSE(turned_camera(runs, mounting.stated));
}

}  // namespace
}  // namespace vildar
