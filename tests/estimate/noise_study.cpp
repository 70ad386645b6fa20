#include <cmath>

#include <gtest/gtest.h>

#include "estimate/vehicle.h"
#include "simulated_pass.h"
#include "study.h"

namespace vildar {
namespace {

constexpr int kTrials = 300;
constexpr double kCoverageSlack = 0.038;  // three binomial sigmas about 0.95

struct Disturbance {
  double sigma_px = 0.1;
  double stated_sigma_px = 0.1;
  double shake_px = 0.0;           // common to the lamps of a frame, per axis
  double shake_correlation = 0.0;  // from frame to frame
  double outliers = 0.0;           // share of centroids displaced by 15 sigma
};

void disturb(VehicleTrack& track, const Disturbance& with, Random& random) {
  const auto draw = [&] { return Eigen::Vector2d(random.normal(), random.normal()); };
  Eigen::Vector2d shake = draw();
  for (VehicleSighting& sighting : track.sightings) {
    shake = with.shake_correlation * shake +
            std::sqrt(1.0 - with.shake_correlation * with.shake_correlation) * draw();
    for (auto* lamp : {&sighting.left, &sighting.right}) {
      if (!*lamp) continue;
      (*lamp)->centre_px += with.shake_px * shake;
      (*lamp)->centre_sigma_px.setConstant(with.stated_sigma_px);
      if (random.uniform() < with.outliers) (*lamp)->centre_px += 15.0 * with.sigma_px * draw();
    }
  }
}

// Share of passes whose 95 % interval holds the truth. The scale is all but known, so that the
// interval is that of the bearings' errors.
double coverage(const Disturbance& with) {
  Random random(20260103);
  Site site = simulated::mast_site(4.0);
  site.lamps.height_m->std = 0.005;
  site.lamps.separation_m->std = 0.005;
  int covered = 0, used = 0;
  for (int i = 0; i < kTrials; ++i) {
    simulated::Vehicle vehicle;
    vehicle.speed_mps = random.uniform(8.0, 35.0);
    vehicle.acceleration_mps2 = random.normal(0.0, 1.5);
    vehicle.lateral_m = random.normal(-4.0, 0.3);
    vehicle.height_m = random.normal(0.65, 0.005);
    vehicle.separation_m = random.normal(1.2, 0.005);
    const simulated::View view{.to_s = 50.0 / vehicle.speed_mps, .sigma_px = with.sigma_px};
    VehicleTrack track = simulated::track_of(vehicle, site, view, random);
    disturb(track, with, random);
    const VehicleResult result = estimate_vehicle(track, site, {}).result;
    if (result.withheld) continue;
    ++used;
    const double truth_mps = vehicle.speed_at_mps(result.speed.time_s);
    covered += result.speed.lo95_mps <= truth_mps && truth_mps <= result.speed.hi95_mps;
  }
  EXPECT_GE(used, kTrials * 95 / 100);
  return covered / static_cast<double>(used);
}

using NoiseStudy = Study;

TEST_F(NoiseStudy, StatedSigma) { EXPECT_NEAR(coverage({}), 0.95, kCoverageSlack); }

TEST_F(NoiseStudy, SigmaStatedTenTimesTooSmall) {
  EXPECT_NEAR(coverage({.sigma_px = 1.0, .stated_sigma_px = 0.1}), 0.95, kCoverageSlack);
}

TEST_F(NoiseStudy, Outliers) {
  EXPECT_NEAR(coverage({.outliers = 0.02}), 0.95, kCoverageSlack);
  EXPECT_NEAR(coverage({.outliers = 0.10}), 0.95, kCoverageSlack);
}

TEST_F(NoiseStudy, ShakingCamera) {
  EXPECT_NEAR(coverage({.shake_px = 2.0}), 0.95, kCoverageSlack);
  // Of slow shake a short track shows little: erring toward the wide side is right.
  EXPECT_GE(coverage({.shake_px = 2.0, .shake_correlation = 0.8}), 0.95 - kCoverageSlack);
  EXPECT_GE(coverage({.shake_px = 2.0, .shake_correlation = 0.95}), 0.95 - kCoverageSlack);
}

}  // namespace
}  // namespace vildar
