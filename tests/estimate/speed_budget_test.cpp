#include "estimate/speed_budget.h"

#include <cmath>
#include <map>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "estimate/site_doubts.h"
#include "estimate/vehicle.h"
#include "simulated_pass.h"

namespace vildar {
namespace {

struct Lengths {
  double lateral_std_m, height_std_m, separation_std_m;
};

// The scale's share in closed form: lane 4 m off, lamps 3.35 m below the camera and 1.2 m apart.
double floor_of(const Lengths& known) {
  const auto information = [](double length_m, double std_m) {
    return length_m * length_m / (std_m * std_m);
  };
  return 1.0 / std::sqrt(information(4.0, known.lateral_std_m) +
                         information(4.0 - 0.65, known.height_std_m) +
                         information(1.2, known.separation_std_m));
}

VehicleResult measured(const Lengths& known) {
  Site site = simulated::mast_site(4.0);
  site.road.lanes[0].lateral_m.std = known.lateral_std_m;
  site.lamps.height_m->std = known.height_std_m;
  site.lamps.separation_m->std = known.separation_std_m;
  simulated::Vehicle vehicle;
  vehicle.height_m = 0.65;
  vehicle.separation_m = 1.2;
  // Few frames and poor centroids, so that shape and scale are of like size.
  const simulated::View view{.to_s = 0.6, .frame_rate_hz = 15.0, .sigma_px = 0.3};
  Random random(5);
  return estimate_vehicle(simulated::track_of(vehicle, site, view, random), site, {}).result;
}

double relative(const VehicleResult& result) {
  return result.speed.std_mps / result.speed.speed_mps;
}

TEST(SpeedBudget, SigmaIsShapeAndTheScalesClosedForm) {
  const Lengths loose{0.3, 0.1, 0.15}, tight{0.03, 0.01, 0.015};
  const VehicleResult one = measured(loose), other = measured(tight);
  ASSERT_TRUE(one.budget && other.budget);
  EXPECT_NEAR(one.budget->scale / floor_of(loose), 1.0, 0.01);
  EXPECT_NEAR(other.budget->scale / floor_of(tight), 1.0,
              0.02);  // the noise moves the lengths found
  // The shape by another site's knowledge, the scale in closed form: their squares add.
  const double shape = std::sqrt(std::pow(relative(other), 2) - std::pow(floor_of(tight), 2));
  EXPECT_NEAR(std::hypot(shape, floor_of(loose)) / relative(one), 1.0, 0.01);
  EXPECT_NEAR(std::hypot(one.budget->shape, one.budget->scale), relative(one), 1e-9);
}

TEST(SpeedBudget, NamesWhatFixesTheScale) {
  const VehicleResult result = measured({0.3, 0.1, 0.15});
  ASSERT_TRUE(result.budget);
  const double all = std::pow(floor_of({0.3, 0.1, 0.15}), -2);
  const auto& shares = result.budget->scale_shares;
  EXPECT_NEAR(shares.at("lamp_height"), std::pow(3.35 / 0.1, 2) / all, 0.02);
  EXPECT_NEAR(shares.at("lane"), std::pow(4.0 / 0.3, 2) / all, 0.02);
  EXPECT_NEAR(shares.at("lamp_separation"), std::pow(1.2 / 0.15, 2) / all, 0.02);
  EXPECT_FALSE(shares.contains("acceleration"));
}

TEST(SpeedBudget, ChiSquareIsOneForHonestSigmas) {
  const VehicleResult result = measured({0.3, 0.1, 0.15});
  constexpr double kSlack = 0.9;  // four sigmas of 2 / degrees of freedom, some 30
  EXPECT_NEAR(result.chi2_per_dof.at("camera"), 1.0, kSlack);
}

// Vehicles as the site says that they are come out off what it says by one sigma. Of a camera that
// hangs lower than stated all come out alike: the lamps, 2.75 m below it, too high.
TEST(SpeedBudget, PullsAreOfOneSigmaWhereTheSiteIsRight) {
  constexpr int kVehicles = 300;
  const Site site = simulated::mast_site(4.0);
  Site lower = site;
  lower.camera->position_m[2].mean = 3.4;
  std::map<std::string, double> sums, squares;
  std::vector<VehicleResult> right, wrong;
  Random random(20261126);
  for (int i = 0; i < kVehicles; ++i) {
    simulated::Vehicle vehicle;
    vehicle.lateral_m = random.normal(-4.0, 0.3);
    vehicle.height_m = random.normal(0.65, 0.1);
    vehicle.separation_m = random.normal(1.2, 0.15);
    right.push_back(
        estimate_vehicle(simulated::track_of(vehicle, site, {}, random), site, {}).result);
    ASSERT_TRUE(right.back().budget);
    for (const auto& [name, pull] : right.back().budget->prior_pulls) {
      sums[name] += pull;
      squares[name] += pull * pull;
    }
    if (wrong.size() < 12)
      wrong.push_back(
          estimate_vehicle(simulated::track_of(vehicle, lower, {}, random), site, {}).result);
  }
  for (const char* name : {"lamp_height", "lamp_separation", "lane"}) {
    constexpr double kSlack = 4.0;  // of the standard errors of a mean and of a variance
    EXPECT_NEAR(sums.at(name) / kVehicles, 0.0, kSlack / std::sqrt(kVehicles)) << name;
    EXPECT_NEAR(squares.at(name) / kVehicles, 1.0, kSlack * std::sqrt(2.0 / kVehicles)) << name;
  }
  EXPECT_TRUE(site_doubts(right, site.road).empty());
  const auto doubts = site_doubts(wrong, site.road);
  ASSERT_FALSE(doubts.empty());
  EXPECT_NE(doubts[0].find("vehicles come out higher than the site file says"), std::string::npos)
      << doubts[0];
  EXPECT_TRUE(site_doubts(std::span(wrong).first(1), site.road).empty());
}

}  // namespace
}  // namespace vildar
