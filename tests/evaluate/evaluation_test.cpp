#include "evaluate/evaluation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "evaluate/hand_made.h"

namespace vildar {
namespace {

using Outcome = VehicleScore::Outcome;

// One vehicle of each fate: measured, withheld, missed, never in view; and a ghost and a second
// speed.
struct Night {
  std::vector<TruthVehicle> truth;
  RunFolder run;

  Night() {
    truth = {truth_at("seen", 100, 0, 39), truth_at("kept", 300, 0, 39),
             truth_at("missed", 500, 0, 39), truth_at("hidden", 700, 0, 39)};
    for (TruthSighting& sighting : truth[3].sightings) sighting.occluded = true;
    // Speeds up from 20 to 23.9 m/s.
    for (TruthSighting& sighting : truth[0].sightings) sighting.speed_mps = 20.0 + sighting.t_s;
    run.vehicles = {measured(run_at("1", 101, 0, 29), 1.05, 21.35), run_at("2", 300, 0, 39),
                    measured(run_at("3", 1500, 0, 9), 0.5, 12.0),
                    measured(run_at("4", 100, 30, 39), 3.5, 24.0)};
    run.vehicles[1].direction = "receding";
    run.vehicles[0].methods = {{"fused", {StatedSpeed{1.0, 21.0, {}, {}, {}}, ""}},
                               {"geometry_camera", {StatedSpeed{2.0, 22.5, {}, {}, {}}, ""}}};
    run.vehicles[1].methods = {{"fused", {std::nullopt, "no_scale"}}};
    run.vehicles[2].methods = {{"fused", {StatedSpeed{0.5, 12.0, {}, {}, {}}, ""}}};
  }
};

TEST(Evaluation, CountsEveryFate) {
  const Night night;
  const Evaluation result = evaluate(night.truth, night.run);
  EXPECT_EQ(result.in_view, 3U);
  EXPECT_EQ(result.not_in_view, 1U);
  EXPECT_EQ(result.matched, 2U);
  EXPECT_EQ(result.measured, 1U);
  EXPECT_EQ(result.missed, 1U);
  EXPECT_EQ(result.false_speeds, 2U);
  EXPECT_EQ(result.duplicates, 1U);
  EXPECT_EQ(result.wrong_direction, 1U);
  EXPECT_EQ(result.withheld.at("too_short"), 1U);
  std::vector<Outcome> outcomes;
  for (const VehicleScore& score : result.vehicles) outcomes.push_back(score.outcome);
  EXPECT_EQ(outcomes,
            (std::vector{Outcome::measured, Outcome::withheld, Outcome::missed,
                         Outcome::not_in_view, Outcome::false_speed, Outcome::duplicate}));
}

// A run of every second frame of the truth, whose lamps move on by their width in ten of these.
TEST(Evaluation, FramesOfAnotherRateAreMatchedByTime) {
  std::vector<TruthVehicle> truth{truth_at("one", 100, 0, 39)};
  for (TruthSighting& sighting : truth[0].sightings)
    sighting.lamps = pair_at(100.0 + 4.0 * static_cast<double>(sighting.frame), 500.0);
  RunFolder run;
  run.vehicles = {measured(run_at("1", 0, 0, 19), 1.0, 20.0)};
  for (RunSighting& sighting : run.vehicles[0].sightings) {
    sighting.t_s = 0.2 * static_cast<double>(sighting.frame);
    sighting.lamps = pair_at(100.0 + 8.0 * static_cast<double>(sighting.frame), 500.0);
  }
  const Evaluation result = evaluate(truth, run);
  EXPECT_EQ(result.vehicles[0].outcome, Outcome::measured);
  EXPECT_EQ(result.matched, 1U);
  EXPECT_EQ(result.false_speeds, 0U);
  EXPECT_FALSE(result.tracking);
  ASSERT_EQ(result.notes.size(), 1U);
  EXPECT_NE(result.notes[0].find("matched by time"), std::string::npos) << result.notes[0];
}

// Frames that are missing while the stamps go on as if none were: the numbers are right.
TEST(Evaluation, FramesWhoseStampsAreOffAreMatchedByTheirNumbers) {
  const Night night;
  RunFolder late = night.run;
  for (RunVehicle& vehicle : late.vehicles)
    for (RunSighting& sighting : vehicle.sightings)
      sighting.t_s = 0.08 * static_cast<double>(sighting.frame);
  const Evaluation result = evaluate(night.truth, late);
  EXPECT_EQ(result.matched, 2U);
  EXPECT_TRUE(result.tracking);
  EXPECT_TRUE(result.notes.empty());
}

TEST(Evaluation, ComparesSpeedsAtTheRunsOwnTime) {
  const Night night;
  const Evaluation result = evaluate(night.truth, night.run);
  const VehicleScore& seen = result.vehicles[0];
  EXPECT_NEAR(*seen.true_mps, 21.05, kExact);
  EXPECT_NEAR(seen.pair()->error_mps(), 0.30, kExact);
  EXPECT_NEAR(*seen.pair()->z(), 0.6, kExact);
  EXPECT_EQ(seen.pair()->inside_95(), true);
  EXPECT_EQ(result.speed.count, 1U);
  EXPECT_NEAR(*result.speed.kmh.bias, 1.08, 1e-9);
  EXPECT_EQ(result.vehicles[5].vehicle_id, "seen");
  EXPECT_NEAR(*result.vehicles[5].true_mps, 23.5, kExact);
}

TEST(Evaluation, ScoresMethodsSideBySide) {
  const Night night;
  const Evaluation result = evaluate(night.truth, night.run);
  const MethodScore& fused = result.methods.at("fused");
  EXPECT_EQ(fused.measured, 1U);
  EXPECT_EQ(fused.withheld.at("no_scale"), 1U);
  EXPECT_EQ(fused.false_speeds, 1U);
  EXPECT_NEAR(*fused.speed.kmh.max, 0.0, 1e-9);
  EXPECT_NEAR(*result.methods.at("geometry_camera").speed.kmh.bias, 1.8, 1e-9);
}

TEST(Evaluation, TracksAreScoredOnVisibleLamps) {
  const Night night;
  const Evaluation result = evaluate(night.truth, night.run);
  ASSERT_TRUE(result.tracking);
  // 120 visible sightings; 30 + 10 + 40 are found, 10 are a ghost, the second track switches once.
  EXPECT_EQ(result.tracking->clear.true_positives, 80);
  EXPECT_EQ(result.tracking->clear.false_negatives, 40);
  EXPECT_EQ(result.tracking->clear.false_positives, 10);
  EXPECT_EQ(result.tracking->clear.id_switches, 1);
  EXPECT_NEAR(result.tracking->clear.mota(), (80.0 - 10.0 - 1.0) / 120.0, kExact);
}

TEST(Evaluation, PlacesAreComparedFrameByFrameFromTheCamera) {
  std::vector<TruthVehicle> truth{truth_at("a", 100, 0, 1)};
  RunFolder run;
  run.vehicles = {run_at("1", 100, 0, 1)};
  for (std::size_t i = 0; i < 2; ++i) {
    TruthSighting& there = truth[0].sightings[i];
    there.x_m = there.range_m = 40.0;
    there.y_m = -3.0;
    // The camera stands at (10, 1): azimuth atan2(-4, 30). Errors of 3 and -4 mrad and metres.
    const double error = i == 0 ? 3.0 : -4.0;
    run.vehicles[0].sightings[i].azimuth_rad = std::atan2(-4.0, 30.0) + 1e-3 * error;
    run.vehicles[0].sightings[i].range_m = 40.0 + error;
  }
  const Evaluation result = evaluate(truth, run, {{10.0, 1.0}, 0.0, 1});
  EXPECT_NEAR(*result.azimuth_rms_rad, 1e-3 * std::sqrt(12.5), kExact);
  EXPECT_NEAR(*result.range_rms_m, std::sqrt(12.5), kExact);
  EXPECT_NEAR(*result.vehicles[0].range_rms_m, std::sqrt(12.5), kExact);
}

TEST(Evaluation, WithARollingShutterABearingHoldsAtItsRow) {
  // 25 m/s toward the sensor; row 500 of 1080 is read 0.5 / 1080 + 500 / 1080 - 0.5 of 15 ms from
  // the middle row, here before it, when the vehicle was still further out.
  std::vector<TruthVehicle> truth{truth_at("a", 100, 0, 10)};
  for (TruthSighting& sighting : truth[0].sightings) {
    sighting.x_m = 40.0 - 25.0 * sighting.t_s;
    sighting.y_m = -6.0;
  }
  const double early_s = (0.5 - 500.5 / 1080.0) * 0.015;
  RunFolder run;
  run.vehicles = {run_at("1", 100, 1, 10)};
  for (RunSighting& sighting : run.vehicles[0].sightings) {
    const double t_s = 0.1 * static_cast<double>(sighting.frame) - early_s;
    sighting.azimuth_rad = std::atan2(-6.0, 40.0 - 25.0 * t_s);
  }
  constexpr double kRounding = 1e-9;
  EXPECT_NEAR(*evaluate(truth, run, {{0.0, 0.0}, 0.015, 1080}).azimuth_rms_rad, 0.0, kRounding);
  EXPECT_GT(*evaluate(truth, run, {}).azimuth_rms_rad, 1e-5);
}

TEST(Evaluation, AnEmptyRunMissesAllAndAnEmptyRoadMakesAllFalse) {
  const Night night;
  const Evaluation blind = evaluate(night.truth, {});
  EXPECT_EQ(blind.missed, 3U);
  ASSERT_TRUE(blind.tracking);
  EXPECT_EQ(blind.tracking->clear.false_negatives, 120);
  const Evaluation empty_road = evaluate({}, night.run);
  EXPECT_EQ(empty_road.false_speeds, 3U);
  EXPECT_FALSE(empty_road.tracking);
  EXPECT_TRUE(evaluate({}, {}).vehicles.empty());
}

TEST(Evaluation, ASpeedBeyondTheTruthIsNotScoredAndSaidSo) {
  RunFolder run;
  run.vehicles = {measured(run_at("1", 100, 0, 39), 9.0, 20.0)};
  const Evaluation result = evaluate({truth_at("a", 100, 0, 39)}, run);
  EXPECT_EQ(result.measured, 1U);
  EXPECT_EQ(result.without_truth, 1U);
  EXPECT_EQ(result.speed.count, 0U);
  EXPECT_EQ(result.notes.size(), 1U);
}

}  // namespace
}  // namespace vildar
