#include <cmath>

#include <gtest/gtest.h>

#include "estimate/vehicle.h"
#include "simulated_pass.h"
#include "study.h"

namespace vildar {
namespace {

constexpr int kTrials = 300;

struct Found {
  double rmse_percent = 0.0;
  double coverage = 0.0;
  double z_variance = 0.0;
  int withheld = 0;
};

// Passes from 60 to 10 m whose vehicles are drawn from the site's own priors.
Found study(double camera_height_m, std::uint64_t seed) {
  Random random(seed);
  const Site site = simulated::mast_site(camera_height_m);
  Found study;
  int used = 0;
  for (int i = 0; i < kTrials; ++i) {
    simulated::Vehicle vehicle;
    vehicle.speed_mps = random.uniform(8.0, 35.0);
    vehicle.acceleration_mps2 = random.normal(0.0, 1.5);
    vehicle.lateral_m = random.normal(-4.0, 0.3);
    vehicle.height_m = random.normal(0.65, 0.1);
    vehicle.separation_m = random.normal(1.2, 0.15);
    const simulated::View view{.to_s = 50.0 / vehicle.speed_mps};
    const VehicleResult result =
        estimate_vehicle(simulated::track_of(vehicle, site, view, random), site, {}).result;
    if (result.withheld) {
      ++study.withheld;
      continue;
    }
    ++used;
    const double truth_mps = vehicle.speed_at_mps(result.speed.time_s);
    const double error_mps = result.speed.speed_mps - truth_mps;
    study.rmse_percent += std::pow(error_mps / truth_mps, 2);
    study.coverage += result.speed.lo95_mps <= truth_mps && truth_mps <= result.speed.hi95_mps;
    study.z_variance += std::pow(error_mps / result.speed.std_mps, 2);
  }
  study.rmse_percent = 100.0 * std::sqrt(study.rmse_percent / used);
  study.coverage /= used;
  study.z_variance /= used;
  return study;
}

// An RMSE of n trials scatters by 1 / sqrt(2 n), a coverage by sqrt(.95 .05 / n), the variance of
// standard normal z by sqrt(2 / n); three of each.
constexpr double kRmseSlack = 0.1225;
constexpr double kCoverageSlack = 0.038;
constexpr double kVarianceSlack = 0.245;

void expect_study(double camera_height_m, double rmse_percent, std::uint64_t seed) {
  const Found found = study(camera_height_m, seed);
  EXPECT_NEAR(found.rmse_percent / rmse_percent, 1.0, kRmseSlack) << found.rmse_percent << " %";
  EXPECT_NEAR(found.coverage, 0.95, kCoverageSlack);
  EXPECT_NEAR(found.z_variance, 1.0, kVarianceSlack);
  EXPECT_LE(found.withheld, kTrials / 100);
}

using GeometryStudy = Study;

// The floors that follow from the spread of height, separation and lane: 2.7 and 5.7 %.
TEST_F(GeometryStudy, HighCamera) { expect_study(4.0, 2.71, 20260101); }
TEST_F(GeometryStudy, LowCamera) { expect_study(1.5, 5.64, 20260102); }

}  // namespace
}  // namespace vildar
