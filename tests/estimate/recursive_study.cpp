#include <cmath>
#include <cstdio>

#include "core/clock.h"
#include "delay_pass.h"
#include "estimate/mixture.h"
#include "estimate/recursive_fit.h"
#include "estimate/vehicle.h"
#include "study.h"

namespace vildar {
namespace {

constexpr int kTrials = 1000;

using RecursiveStudy = Study;

TEST_F(RecursiveStudy, AsGoodAsTheBatchAtTwentyMetres) {
  for (const double camera_height_m : {4.0, 1.5})
    for (const double range_m : {40.0, 30.0, 20.0}) {
      Random random(20260151);
      const Site site = simulated::mast_site(camera_height_m);
      double live2 = 0.0, batch2 = 0.0;
      int used = 0, covered = 0;
      for (int i = 0; i < kTrials; ++i) {
        const simulated::Vehicle vehicle = simulated::random_vehicle(1.5, random);
        VehicleTrack track =
            simulated::track_of(vehicle, site, {.to_s = 50.0 / vehicle.speed_mps}, random);
        std::erase_if(track.sightings, [&](const VehicleSighting& sighting) {
          return vehicle.along_at_m(seconds_of(sighting.time)) < range_m;
        });
        RecursiveFit live(site, track);
        for (const VehicleSighting& sighting : track.sightings) live.add(sighting);
        std::vector<std::string> warnings;
        const auto batch = fit_trajectories(track, Camera(*site.camera), site, warnings);
        const auto speed = live.speed();
        if (!std::holds_alternative<SpeedEstimate>(speed) || std::holds_alternative<Miss>(batch))
          continue;
        ++used;
        const auto& found = std::get<SpeedEstimate>(speed);
        const double truth_mps = vehicle.speed_at_mps(found.time_s);
        live2 += std::pow(found.speed_mps / truth_mps - 1.0, 2);
        const auto state = mixed_state(std::get<std::vector<Trajectory>>(batch), found.time_s);
        batch2 += std::pow(state.over_ground_mps / truth_mps - 1.0, 2);
        covered += found.lo95_mps <= truth_mps && truth_mps <= found.hi95_mps;
      }
      std::printf(
          "camera %.1f m, at %.0f m: recursive %.2f %%, batch %.2f %%, coverage %.3f, n %d\n",
          camera_height_m, range_m, 100.0 * std::sqrt(live2 / used),
          100.0 * std::sqrt(batch2 / used), covered / static_cast<double>(used), used);
      EXPECT_GE(used, kTrials * 97 / 100);
      if (range_m == 20.0) {
        EXPECT_LE(std::sqrt(live2 / batch2), 1.02);
        EXPECT_GE(covered, used * 93 / 100);
      }
    }
}

}  // namespace
}  // namespace vildar
