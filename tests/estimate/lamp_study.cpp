#include <cmath>
#include <cstdio>

#include "estimate/vehicle.h"
#include "lamp_population.h"
#include "study.h"

namespace vildar {
namespace {

constexpr int kTrials = 1000;

struct Found {
  int measured = 0, covered = 0;
  double square = 0.0, sigma2 = 0.0;

  double coverage() const { return static_cast<double>(covered) / measured; }
};

// Passes from 60 to 10 m of vehicles drawn from one class of the site's population.
Found study(const Site& site, const LampClass& kind, Random& random) {
  Found found;
  for (int i = 0; i < kTrials; ++i) {
    simulated::Vehicle vehicle;
    vehicle.speed_mps = random.uniform(8.0, 35.0);
    const double seen_s = 50.0 / vehicle.speed_mps;
    // None comes to rest in view.
    do vehicle.acceleration_mps2 = random.normal(0.0, 1.5);
    while (vehicle.speed_at_mps(seen_s) < 3.0);
    // A motorcycle rides anywhere in its lane.
    vehicle.lateral_m = random.normal(-4.0, kind.separation_m ? 0.3 : 0.69);
    vehicle.height_m = random.normal(kind.height_m.mean, kind.height_m.std);
    if (kind.separation_m)
      vehicle.separation_m = random.normal(kind.separation_m->mean, kind.separation_m->std);
    const simulated::View view{.to_s = seen_s, .single_lamp = !kind.separation_m};
    const VehicleResult result =
        estimate_vehicle(simulated::track_of(vehicle, site, view, random), site, {}).result;
    if (result.withheld) continue;
    ++found.measured;
    const double truth_mps = vehicle.speed_at_mps(result.speed.time_s);
    found.covered += result.speed.lo95_mps <= truth_mps && truth_mps <= result.speed.hi95_mps;
    found.square += std::pow(result.speed.speed_mps / truth_mps - 1.0, 2);
    found.sigma2 += std::pow(result.speed.std_mps / result.speed.speed_mps, 2);
  }
  return found;
}

using LampStudy = Study;

TEST_F(LampStudy, EveryClassIsCovered) {
  constexpr double kSlack = 0.0207;  // three binomial sigmas of 95 %
  Random random(20260151);
  for (const double camera_height_m : {4.0, 1.5}) {
    const Site site = simulated::mixed_site(camera_height_m);
    for (const LampClass& kind : site.lamps.classes) {
      const Found found = study(site, kind, random);
      std::printf("camera %.1f m, %s: measured %d, coverage %.3f, rmse %.2f %%, sigma %.2f %%\n",
                  camera_height_m, kind.id.c_str(), found.measured, found.coverage(),
                  100.0 * std::sqrt(found.square / found.measured),
                  100.0 * std::sqrt(found.sigma2 / found.measured));
      std::fflush(stdout);
      EXPECT_GE(found.measured, kTrials * 97 / 100);
      EXPECT_GE(found.coverage(), 0.95 - kSlack);
    }
  }
}

}  // namespace
}  // namespace vildar
