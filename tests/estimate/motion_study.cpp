#include <cmath>
#include <cstdio>

#include "estimate/vehicle.h"
#include "simulated_pass.h"
#include "study.h"

namespace vildar {
namespace {

constexpr int kTrials = 1000;

using MotionStudy = Study;

// Cruising, then from some moment in view on another acceleration: not what the model says.
TEST_F(MotionStudy, ABrakingThatBeginsInViewIsCovered) {
  constexpr double kSlack = 0.0207;  // three binomial sigmas of 95 %
  struct Case {
    double camera_height_m, height_std_m, change_mps2;
  };
  for (const Case& tried : {Case{4.0, 0.1, -3.0}, Case{4.0, 0.01, -1.0}, Case{4.0, 0.01, -3.0},
                            Case{6.0, 0.01, -6.0}, Case{6.0, 0.01, 2.0}}) {
    Random random(20260161);
    Site site = simulated::mast_site(tried.camera_height_m);
    site.lamps.height_m->std = tried.height_std_m;
    int covered = 0, withheld = 0, trimmed = 0;
    double square = 0.0, sigma2 = 0.0;
    for (int i = 0; i < kTrials; ++i) {
      simulated::Vehicle vehicle;
      vehicle.speed_mps = random.uniform(15.0, 35.0);
      vehicle.lateral_m = random.normal(-4.0, 0.3);
      vehicle.height_m = random.normal(0.65, tried.height_std_m);
      vehicle.separation_m = random.normal(1.2, 0.15);
      // It never comes to rest.
      const double seen_s = 40.0 / vehicle.speed_mps;
      vehicle.changes = {{random.uniform(0.2, 0.8) * seen_s, tried.change_mps2}};
      const VehicleResult result =
          estimate_vehicle(simulated::track_of(vehicle, site, {.to_s = seen_s}, random), site, {})
              .result;
      if (result.withheld) {
        ++withheld;
        continue;
      }
      trimmed += !result.warnings.empty();
      const double truth_mps = vehicle.speed_at_mps(result.speed.time_s);
      covered += result.speed.lo95_mps <= truth_mps && truth_mps <= result.speed.hi95_mps;
      square += std::pow(result.speed.speed_mps / truth_mps - 1.0, 2);
      sigma2 += std::pow(result.speed.std_mps / result.speed.speed_mps, 2);
    }
    const double used = kTrials - withheld;
    std::printf(
        "camera %.0f m, lamps +- %.2f m, %+.0f m/s^2: withheld %d, trimmed %d, coverage %.3f, rmse "
        "%.2f %%, sigma %.2f %%\n",
        tried.camera_height_m, tried.height_std_m, tried.change_mps2, withheld, trimmed,
        covered / used, 100.0 * std::sqrt(square / used), 100.0 * std::sqrt(sigma2 / used));
    std::fflush(stdout);
    EXPECT_GE(covered / used, 0.95 - kSlack);
    EXPECT_LE(withheld, kTrials / 20);
  }
}

}  // namespace
}  // namespace vildar
