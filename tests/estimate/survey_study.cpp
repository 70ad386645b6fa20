#include <cmath>
#include <cstdio>

#include "estimate/vehicle.h"
#include "simulated_pass.h"
#include "study.h"

namespace vildar {
namespace {

constexpr int kTrials = 1000;

using SurveyStudy = Study;

// Every fact of the site at survey accuracy: what a speed meter must hold.
TEST_F(SurveyStudy, AThousandPassesWithinThreeKmhOrThreePercent) {
  for (const double mast_m : {4.0, 6.0}) {
    Random random(20260131);
    Site site = simulated::mast_site(mast_m);
    site.lamps.height_m = Uncertain{0.65, 0.01};
    site.camera->yaw_rad.std = site.camera->pitch_rad.std = 0.5e-3;
    int outside = 0, withheld = 0, covered = 0;
    double bias_kmh = 0.0, worst_kmh = 0.0, square = 0.0;
    for (int i = 0; i < kTrials; ++i) {
      simulated::Vehicle vehicle;
      vehicle.speed_mps = random.uniform(20.0, 200.0) / 3.6;
      vehicle.acceleration_mps2 = random.normal(0.0, 1.0);
      vehicle.lateral_m = random.normal(-4.0, 0.3);
      vehicle.height_m = random.normal(0.65, 0.01);
      vehicle.separation_m = random.normal(1.2, 0.15);
      const double seen_s = std::clamp(50.0 / vehicle.speed_mps, 1.0, 2.5);
      vehicle.along_m = vehicle.speed_mps * seen_s + 12.0;
      Site truth = site;
      truth.camera->yaw_rad.mean += 0.5e-3 * random.normal();
      truth.camera->pitch_rad.mean += 0.5e-3 * random.normal();
      const simulated::View view{.to_s = seen_s};
      const VehicleResult result =
          estimate_vehicle(simulated::track_of(vehicle, truth, view, random), site, {}).result;
      if (result.withheld) {
        ++withheld;
        continue;
      }
      const double truth_mps = vehicle.speed_at_mps(result.speed.time_s);
      const double error_kmh = 3.6 * (result.speed.speed_mps - truth_mps);
      const double allowed_kmh = std::max(3.0, 0.03 * 3.6 * truth_mps);
      outside += std::abs(error_kmh) > allowed_kmh;
      bias_kmh += error_kmh / kTrials;
      worst_kmh = std::max(worst_kmh, std::abs(error_kmh));
      square += std::pow(error_kmh / (3.6 * truth_mps), 2) / kTrials;
      covered += result.speed.lo95_mps <= truth_mps && truth_mps <= result.speed.hi95_mps;
    }
    std::printf(
        "mast %.0f m: outside %d, withheld %d, bias %+.3f km/h, worst %.2f km/h, rmse %.2f %%, "
        "coverage %.3f\n",
        mast_m, outside, withheld, bias_kmh, worst_kmh, 100.0 * std::sqrt(square),
        covered / static_cast<double>(kTrials - withheld));
    EXPECT_EQ(outside, 0);
    EXPECT_LE(withheld, kTrials / 100);
    EXPECT_LT(std::abs(bias_kmh), 0.3);
    EXPECT_GE(covered, (kTrials - withheld) * 93 / 100);
  }
}

}  // namespace
}  // namespace vildar
