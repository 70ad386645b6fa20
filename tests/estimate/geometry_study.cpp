#include <cmath>
#include <cstdio>
#include <string>

#include "core/quantity.h"
#include "estimate/vehicle.h"
#include "simulated_pass.h"
#include "study.h"

namespace vildar {
namespace {

constexpr int kTrials = 1000;
constexpr double kCoverageSlack = 0.0207;  // three binomial sigmas of 95 %

struct Case {
  std::string name;
  Site site;
  double from_m = 60.0, to_m = 10.0;  ///< of the path
  double fastest_mps = 35.0;
  double weave_m = 0.0;  ///< to and fro about the lane's middle, each way
};

struct Found {
  int used = 0, covered = 0, ranges = 0, ranges_covered = 0;
  double square = 0.0, sigma2 = 0.0, z_square = 0.0;

  double coverage() const { return static_cast<double>(covered) / used; }
  double range_coverage() const { return static_cast<double>(ranges_covered) / ranges; }
  double rmse() const { return std::sqrt(square / used); }
  double sigma() const { return std::sqrt(sigma2 / used); }
};

double drawn(const Uncertain& prior, Random& random) {
  return random.normal(prior.mean, prior.std);
}

// The world that a site file describes: everything that it calls uncertain is drawn.
Site world_of(const Site& told, Random& random) {
  Site world = told;
  for (Uncertain* angle :
       {&world.camera->yaw_rad, &world.camera->pitch_rad, &world.camera->roll_rad})
    angle->mean = drawn(*angle, random);
  if (world.road.radius_m) {
    world.road.radius_m->mean = drawn(*world.road.radius_m, random);
    world.road.straight_m.mean = drawn(bend_begins_m(world.road), random);
  }
  return world;
}

Found study(const Case& tried, std::uint64_t seed) {
  Random random(seed);
  Found found;
  for (int i = 0; i < kTrials; ++i) {
    const Site world = world_of(tried.site, random);
    simulated::Vehicle vehicle;
    vehicle.along_m = tried.from_m;
    vehicle.speed_mps = random.uniform(8.0, tried.fastest_mps);
    const double seen_s = (tried.from_m - tried.to_m) / vehicle.speed_mps;
    // None comes to rest in view.
    do vehicle.acceleration_mps2 = random.normal(0.0, 1.5);
    while (vehicle.speed_at_mps(seen_s) < 3.0);
    vehicle.lateral_m = drawn(world.road.lanes.front().lateral_m, random);
    vehicle.height_m = drawn(*world.lamps.height_m, random);
    vehicle.separation_m = drawn(*world.lamps.separation_m, random);
    if (tried.weave_m > 0.0)
      vehicle.weave = {tried.weave_m, random.uniform(6.0, 10.0), random.uniform(0.0, 2.0 * kPi)};
    const VehicleEstimate estimate = estimate_vehicle(
        simulated::track_of(vehicle, world, {.to_s = seen_s}, random), tried.site, {});
    const VehicleResult& result = estimate.result;
    if (result.withheld) continue;
    ++found.used;
    const double truth_mps = vehicle.speed_at_mps(result.speed.time_s);
    const double error_mps = result.speed.speed_mps - truth_mps;
    found.square += std::pow(error_mps / truth_mps, 2);
    found.sigma2 += std::pow(result.speed.std_mps / truth_mps, 2);
    found.z_square += std::pow(error_mps / result.speed.std_mps, 2);
    found.covered += result.speed.lo95_mps <= truth_mps && truth_mps <= result.speed.hi95_mps;
    // One row of each track: those of one track err together.
    const TrackRow& row = estimate.rows[estimate.rows.size() / 2];
    if (!row.range_m) continue;
    const double truth_m = simulated::lamps_at(vehicle, world.road, row.time_s).middle_m.x();
    ++found.ranges;
    found.ranges_covered += std::abs(*row.range_m - truth_m) <= 1.96 * *row.range_std_m;
  }
  std::printf(
      "%s: measured %d, rmse %.2f %%, sigma %.2f %%, coverage %.3f, of range %.3f, z2 %.2f\n",
      tried.name.c_str(), found.used, 100.0 * found.rmse(), 100.0 * found.sigma(), found.coverage(),
      found.range_coverage(), found.z_square / found.used);
  std::fflush(stdout);
  return found;
}

void expect_covered(const Found& found) {
  EXPECT_GE(found.used, kTrials * 97 / 100);
  EXPECT_GE(found.coverage(), 0.95 - kCoverageSlack);
  EXPECT_GE(found.range_coverage(), 0.95 - kCoverageSlack);
}

void expect_honest(const Found& found) {
  expect_covered(found);
  EXPECT_LE(found.coverage(), 0.95 + kCoverageSlack);
  EXPECT_LE(found.range_coverage(), 0.95 + kCoverageSlack);
}

using GeometryStudy = Study;

// The floors that follow from the spread of height, separation and lane: 2.71 and 5.64 %.
TEST_F(GeometryStudy, TheBoundIsReached) {
  for (const auto& [height_m, bound] : {std::pair{4.0, 0.0271}, std::pair{1.5, 0.0564}}) {
    const Found found = study(
        {"camera " + std::to_string(height_m) + " m", simulated::mast_site(height_m)}, 20260101);
    expect_honest(found);
    const double standard_error = bound / std::sqrt(2.0 * found.used);
    EXPECT_LE(found.rmse(), 1.05 * bound + 2.0 * standard_error);
    EXPECT_NEAR(found.z_square / found.used, 1.0, 4.0 * std::sqrt(2.0 / found.used));
  }
}

Site curved_site(double camera_height_m, Turn turn, Uncertain radius_m) {
  Site site = simulated::mast_site(camera_height_m);
  site.road.kind = RoadKind::curved;
  site.road.turn = turn;
  site.road.radius_m = radius_m;
  site.road.straight_m.mean = 5.0;
  site.camera->yaw_rad.mean = turn == Turn::left ? 0.25 : -0.25;
  return site;
}

TEST_F(GeometryStudy, CurvesLeftAndRightWhateverIsKnownOfTheirRadius) {
  for (const Turn turn : {Turn::left, Turn::right})
    for (const Uncertain radius_m : {Uncertain{60.0, 0.0}, Uncertain{60.0, 6.0}})
      for (const double weave_m : {0.0, 0.1})
        // A radius called known is taken as good to half a percent, which here it is.
        expect_covered(
            study({(turn == Turn::left ? "left" : "right") + std::string(" turn, 60 +- ") +
                       std::to_string(radius_m.std) + " m, weave " + std::to_string(weave_m) + " m",
                   curved_site(4.0, turn, radius_m), 50.0, 12.0, 20.0, weave_m},
                  20260102));
}

TEST_F(GeometryStudy, APoseKnownToAFewDegrees) {
  Site yawed = simulated::mast_site(4.0);
  yawed.camera->yaw_rad.std = radians_from_degrees(2.5);
  expect_honest(study({"yaw +- 2.5 degrees", yawed}, 20260103));
  Site turned = yawed;
  turned.camera->pitch_rad.std = radians_from_degrees(1.0);
  turned.camera->roll_rad.std = radians_from_degrees(1.0);
  expect_honest(study({"yaw +- 2.5, pitch and roll +- 1 degrees", turned}, 20260104));
}

TEST_F(GeometryStudy, ARollingShutterIsNoSpeed) {
  Site site = simulated::mast_site(4.0);
  site.camera->rolling_shutter_s = 0.025;
  expect_honest(study({"rolling shutter of 25 ms", site}, 20260105));
}

}  // namespace
}  // namespace vildar
