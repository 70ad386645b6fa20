#include <cmath>

#include <gtest/gtest.h>

#include "estimate/bearing_fit.h"
#include "estimate/vehicle.h"
#include "simulated_pass.h"
#include "support/trials.h"

namespace vildar {
namespace {

using simulated::Vehicle;

Site two_lanes() {
  Site site = simulated::mast_site(6.0);
  site.camera->pitch_rad.mean = radians_from_degrees(-8.0);
  site.road.lanes.push_back({"far", {-7.5, 0.3}, 3.5, Direction::oncoming});
  return site;
}

// From 80 m on until it is 12 m away; the change may have begun before, or go on after.
TEST(LaneChange, IsMeasuredAndItsSpeedLiesInItsInterval) {
  constexpr int kTrials = trials(80);
  const Site site = two_lanes();
  Random random(21);
  int measured = 0, inside = 0;
  double squares = 0.0;
  for (int i = 0; i < kTrials; ++i) {
    Vehicle car;
    car.speed_mps = random.uniform(14.0, 33.0);
    car.along_m = 80.0;
    car.height_m = random.normal(0.65, 0.1);
    car.separation_m = random.normal(1.2, 0.15);
    const double seen_s = 68.0 / car.speed_mps;
    const bool to_left = random.uniform(0.0, 1.0) < 0.5;
    car.lateral_m = random.normal(to_left ? -7.5 : -4.0, 0.3);
    car.lane_change = {random.uniform(-1.0, seen_s - 1.0), random.uniform(2.5, 5.0),
                       to_left ? 3.5 : -3.5};
    const VehicleResult result =
        estimate_vehicle(simulated::track_of(car, site, {.to_s = seen_s}, random), site, {}).result;
    if (result.withheld) continue;
    ++measured;
    const double truth_mps =
        std::hypot(car.speed_mps, car.lane_change.left_mps(result.speed.time_s));
    inside += truth_mps > result.speed.lo95_mps && truth_mps < result.speed.hi95_mps;
    squares += std::pow((result.speed.speed_mps - truth_mps) / result.speed.std_mps, 2);
  }
  EXPECT_GE(measured, kTrials * 9 / 10);
  EXPECT_GE(inside, 0.95 * measured - 3.0 * std::sqrt(0.95 * 0.05 * measured));
  EXPECT_LT(std::sqrt(squares / measured), 1.3);
}

// It slides aside without turning, as no wheels let it: no lamps and pose that are likely explain
// it, and what one lane makes of it is no speed.
TEST(LaneChange, ThatNoVehicleMakesHasNoSpeed) {
  constexpr double kPoseStd_rad = 2.6e-3, kSeen_s = 4.2;
  Site site = two_lanes();
  site.camera->yaw_rad.std = site.camera->pitch_rad.std = site.camera->roll_rad.std = kPoseStd_rad;
  Random random(8);
  for (const double aside_m : {1.75, -1.75}) {
    Vehicle car;
    car.speed_mps = 15.0;
    car.along_m = 75.0;
    car.lateral_m = -5.75;
    car.weave = {aside_m, 2.0 * kSeen_s, 0.5 * kPi};
    const VehicleResult result =
        estimate_vehicle(
            simulated::track_of(car, site, {.to_s = kSeen_s, .sigma_px = 0.05}, random), site, {})
            .result;
    EXPECT_EQ(result.withheld, Miss::bad_fit) << aside_m;
  }
}

struct Tally {
  int measured = 0, inside = 0;
  double worst_sigmas = 0.0;
};

// Vehicles ahead of a camera that drives straight, each going aside by so much.
Tally ahead_of_a_dashcam(int trials, double aside_m, bool yaw_rates) {
  constexpr double kOwn_mps = 25.0, kTold_radps = 1e-6;
  Site site = simulated::mast_site(1.3);
  site.camera->pitch_rad = {0.0, 0.005};
  site.road.lanes = {{"right", {-3.5, 0.3}, 3.5, Direction::receding},
                     {"own", {0.0, 0.3}, 3.5, Direction::receding},
                     {"left", {3.5, 0.3}, 3.5, Direction::receding}};
  site.lamps.tail_height_m = Uncertain{0.8, 0.15};
  site.lamps.tail_separation_m = Uncertain{1.2, 0.2};
  site.ego = EgoSite{{kOwn_mps, 0.2}, {}, {}};
  for (double t_s = -0.5; yaw_rates && t_s < 6.0; t_s += 0.1)
    site.ego->trace.push_back({t_s, kOwn_mps, kTold_radps});
  simulated::View view{.to_s = 5.0};
  view.ego_mps = kOwn_mps;
  Random random(5);
  Tally tally;
  for (int i = 0; i < trials; ++i) {
    const double faster_mps = random.uniform(-3.0, 6.0);
    Vehicle car;
    car.speed_mps = -(kOwn_mps + faster_mps);
    car.along_m = faster_mps > 0.0 ? random.uniform(15.0, 30.0) : random.uniform(30.0, 50.0);
    const double to_left_m = random.uniform(0.0, 1.0) < 0.5 ? aside_m : -aside_m;
    car.lateral_m = random.normal(aside_m > 3.5 ? -0.5 * to_left_m : 0.0, 0.3);
    car.height_m = random.normal(0.8, 0.15);
    car.separation_m = random.normal(1.2, 0.2);
    car.lane_change = {random.uniform(0.0, 2.5), random.uniform(3.0, 5.0), to_left_m};
    VehicleTrack track = simulated::track_of(car, site, view, random);
    track.direction = Direction::receding;
    track.kind = LampKind::taillamp;
    const VehicleResult result = estimate_vehicle(track, site, {}).result;
    if (result.withheld) continue;
    const SpeedEstimate& speed = result.speed;
    const double truth_mps = std::hypot(car.speed_mps, car.lane_change.left_mps(speed.time_s));
    ++tally.measured;
    tally.inside += truth_mps > speed.lo95_mps && truth_mps < speed.hi95_mps;
    tally.worst_sigmas =
        std::max(tally.worst_sigmas, std::abs(speed.speed_mps - truth_mps) / speed.std_mps);
  }
  return tally;
}

TEST(LaneChange, AheadOfADashcamIsMeasuredToo) {
  constexpr int kTrials = trials(8);
  for (const auto& [aside_m, yaw_rates] :
       {std::pair(3.5, true), std::pair(7.0, false), std::pair(7.0, true)}) {
    const Tally tally = ahead_of_a_dashcam(kTrials, aside_m, yaw_rates);
    const auto measured = static_cast<double>(tally.measured);
    EXPECT_GE(tally.measured, kTrials - 2) << aside_m << " m, " << yaw_rates;
    EXPECT_GE(tally.inside, 0.95 * measured - 3.0 * std::sqrt(0.95 * 0.05 * measured))
        << aside_m << " m, " << yaw_rates;
    EXPECT_LT(tally.worst_sigmas, 3.5) << aside_m << " m, " << yaw_rates;
  }
}

Outcome<BearingFit> fit_of(double lateral_m, const simulated::LaneChange& change) {
  const Site site = two_lanes();
  Random random(4);
  Vehicle car;
  car.along_m = 80.0;
  car.lateral_m = lateral_m;
  car.height_m = 0.65;
  car.separation_m = 1.2;
  car.lane_change = change;
  return fit_lane_change(simulated::track_of(car, site, {.to_s = 3.4}, random),
                         Camera(*site.camera), site);
}

TEST(LaneChange, IsFollowedAcrossTheRoad) {
  const simulated::LaneChange change{0.6, 2.5, 3.5};
  const auto outcome = fit_of(-7.5, change);
  const auto* fit = std::get_if<BearingFit>(&outcome);
  ASSERT_NE(fit, nullptr);
  EXPECT_TRUE(fit->steady());
  for (double t_s = 0.1; t_s < 3.4; t_s += 0.3) {
    const MotionState state = fit->trajectory.at(t_s);
    const double scale = state.range_m / (80.0 - 20.0 * t_s);  // lamps' lengths have sigmas
    EXPECT_NEAR(scale, 1.0, 0.1) << t_s;
    EXPECT_NEAR(state.lateral_m / scale, -7.5 + change.left_m(t_s), 0.15) << t_s;
  }
}

TEST(LaneChange, IsNoneWhereItGoesFurtherThanALane) {
  EXPECT_TRUE(std::holds_alternative<BearingFit>(fit_of(-8.0, {0.3, 3.1, 4.0})));
  const auto outcome = fit_of(-9.0, {0.3, 3.1, 5.6});
  ASSERT_TRUE(std::holds_alternative<Miss>(outcome));
  EXPECT_EQ(std::get<Miss>(outcome), Miss::bad_fit);
}

// A drift aside by half a metre may be the sway of a mast as well.
TEST(LaneChange, IsNoneByLessThanAMetre) {
  const auto outcome = fit_of(-7.5, {0.6, 2.5, 0.5});
  ASSERT_TRUE(std::holds_alternative<Miss>(outcome));
  EXPECT_EQ(std::get<Miss>(outcome), Miss::bad_fit);
}

Site two_lanes_on_a_bend() {
  Site site = two_lanes();
  site.camera->position_m[2] = {6.0, 0.05};
  site.camera->yaw_rad = {0.0, 0.01};
  site.camera->pitch_rad.std = 0.003;
  site.road.kind = RoadKind::curved;
  site.road.turn = Turn::left;
  site.road.radius_m = Uncertain{150.0, 2.0};
  site.road.straight_m = {0.0, 0.0};
  return site;
}

// By how much the residuals move as a size does.
void expect_slopes_of_steps(const Site& site, std::uint64_t seed, double tolerance) {
  Random random(seed);
  Vehicle car;
  car.along_m = 60.0;
  car.lane_change = {0.5, 2.0, 3.5};
  auto outcome = fit_lane_change(simulated::track_of(car, site, {.to_s = 2.2}, random),
                                 Camera(*site.camera), site);
  ASSERT_TRUE(std::holds_alternative<BearingFit>(outcome));
  const Trajectory& seen = std::get<BearingFit>(outcome).trajectory;
  GeometryProblem problem = seen.problem;
  ASSERT_TRUE(problem.setting.crosses());
  const std::vector<int> free = free_parameters(problem);
  const auto at = geometry_residuals(problem, seen.fit.parameters, free, Slopes::of_path_and_steps);
  ASSERT_TRUE(at);
  constexpr double kSmall = 1e-7, kUnsoftened = 1.8;
  for (std::size_t k = 0; k < problem.setting.steps.size(); ++k) {
    problem.setting.steps[k].size += kSmall;
    const auto moved = geometry_residuals(problem, seen.fit.parameters, free, Slopes::none);
    problem.setting.steps[k].size -= kSmall;
    ASSERT_TRUE(moved);
    const Eigen::VectorXd slope = (moved->values - at->values) / kSmall;
    const Eigen::VectorXd row = at->slopes.row(static_cast<Eigen::Index>(free.size() + k));
    int compared = 0;
    double most = 0.0, off = 0.0;
    for (Eigen::Index i = 0; i < 2 * std::ssize(problem.lamps); i += 2) {
      if (at->values.segment<2>(i).norm() > kUnsoftened) continue;  // weights are held
      ++compared;
      most = std::max(most, row.segment<2>(i).norm());
      off = std::max(off, (slope - row).segment<2>(i).norm());
    }
    EXPECT_LT(off, tolerance * most) << k;
    EXPECT_GT(compared, std::ssize(problem.lamps) / 2);
  }
}

TEST(LaneChange, SlopesByTheStepsAreThoseOfTheResiduals) {
  expect_slopes_of_steps(two_lanes(), 6, 0.001);
  // Further along a bend the pair faces another way, too: by half its width over the radius.
  expect_slopes_of_steps(two_lanes_on_a_bend(), 6, 0.01);
}

struct Crossed {
  int measured = 0, inside = 0, beyond = 0;
  double squares = 0.0;
};

// From 70 m on until they are 10 m away, on left and right bends whose radius is told to 1 %.
Crossed crossed_on_bends(int trials, Uncertain height_m, Uncertain separation_m,
                         const LampsSite& told, std::uint64_t seed) {
  Random random(seed);
  Crossed found;
  for (int i = 0; i < trials; ++i) {
    Site site = two_lanes_on_a_bend();
    site.lamps = told;
    site.road.turn = i % 2 == 0 ? Turn::left : Turn::right;
    const double radius_m = random.uniform(130.0, 300.0);
    site.road.radius_m = Uncertain{radius_m, 0.0};
    Vehicle car;
    car.speed_mps = random.uniform(10.0, 22.0);
    car.along_m = 70.0;
    car.height_m = random.normal(height_m.mean, height_m.std);
    car.separation_m = random.normal(separation_m.mean, separation_m.std);
    const double seen_s = 60.0 / car.speed_mps;
    const bool to_left = random.uniform(0.0, 1.0) < 0.5;
    car.lateral_m = random.normal(to_left ? -7.5 : -4.0, 0.3);
    car.lane_change = {random.uniform(-1.0, seen_s - 2.0), random.uniform(3.0, 6.0),
                       to_left ? 3.5 : -3.5};
    const VehicleTrack track = simulated::track_of(car, site, {.to_s = seen_s}, random);
    site.road.radius_m = Uncertain{random.normal(radius_m, 0.01 * radius_m), 0.01 * radius_m};
    const VehicleResult result = estimate_vehicle(track, site, {}).result;
    if (result.withheld) continue;
    ++found.measured;
    found.inside += car.speed_mps > result.speed.lo95_mps && car.speed_mps < result.speed.hi95_mps;
    const double sigmas = (result.speed.speed_mps - car.speed_mps) / result.speed.std_mps;
    found.beyond += std::abs(sigmas) > 3.0;
    found.squares += sigmas * sigmas;
  }
  return found;
}

// Of concentric lanes the inner one is shorter, a driver keeps his speed and not the arc's angle,
// and may be amid the change when he passes: none of it may pass for another range.
TEST(LaneChange, OnABendIsMeasuredAndItsSpeedLiesInItsInterval) {
  constexpr int kTrials = trials(60);
  constexpr Uncertain kHeight_m{0.65, 0.1}, kSeparation_m{1.2, 0.15};
  const Crossed cars = crossed_on_bends(kTrials, kHeight_m, kSeparation_m, two_lanes().lamps, 23);
  EXPECT_GE(cars.measured, kTrials * 9 / 10);
  EXPECT_GE(cars.inside, 0.95 * cars.measured - 3.0 * std::sqrt(0.95 * 0.05 * cars.measured));
  EXPECT_LE(cars.beyond, kTrials / 50);
  EXPECT_LT(std::sqrt(cars.squares / cars.measured), 1.3);
}

// With the lengths of a car its way is another one.
TEST(LaneChange, OnABendALorryIsNoCarThatGoesAnotherWay) {
  constexpr int kTrials = trials(30);
  constexpr Uncertain kHeight_m{0.95, 0.1}, kSeparation_m{2.0, 0.1};
  LampsSite lamps;
  lamps.classes = {{"car", 0.8, {0.65, 0.08}, Uncertain{1.25, 0.1}},
                   {"lorry", 0.2, kHeight_m, kSeparation_m}};
  const Crossed lorries = crossed_on_bends(kTrials, kHeight_m, kSeparation_m, lamps, 29);
  EXPECT_GE(lorries.measured, kTrials * 9 / 10);
  EXPECT_GE(lorries.inside,
            0.95 * lorries.measured - 3.0 * std::sqrt(0.95 * 0.05 * lorries.measured));
  EXPECT_LE(lorries.beyond, 1);
  EXPECT_LT(std::sqrt(lorries.squares / lorries.measured), 1.3);
}

}  // namespace
}  // namespace vildar
