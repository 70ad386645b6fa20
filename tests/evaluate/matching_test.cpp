#include "evaluate/matching.h"

#include <gtest/gtest.h>

#include "evaluate/hand_made.h"

namespace vildar {
namespace {

TEST(LampSimilarity, FallsWithTheDistanceOfTheMiddlesOverTheSeparation) {
  EXPECT_NEAR(lamp_similarity(pair_at(100, 50), pair_at(100, 50)), 1.0, kExact);
  EXPECT_NEAR(lamp_similarity(pair_at(100, 50), pair_at(110, 50)), 0.75, kExact);
  EXPECT_NEAR(lamp_similarity(pair_at(100, 50), pair_at(100, 62, 80)), 0.7, kExact);
  EXPECT_NEAR(lamp_similarity(pair_at(100, 50), pair_at(140, 50)), 0.0, kExact);
  EXPECT_NEAR(lamp_similarity(pair_at(100, 50), pair_at(400, 50)), 0.0, kExact);
}

TEST(LampSimilarity, FarPairsAreJudgedByTenPixels) {
  EXPECT_NEAR(lamp_similarity(pair_at(100, 50, 2), pair_at(104, 50, 2)), 0.6, kExact);
}

TEST(LampSimilarity, OneLampSeenIsComparedWithTheNearer) {
  const LampPixels right_alone{std::nullopt, Eigen::Vector2d(122, 50)};
  EXPECT_NEAR(lamp_similarity(pair_at(100, 50), right_alone), 1.0 - 2.0 / 40.0, kExact);
  const LampPixels motorcycle{Eigen::Vector2d(100, 50), std::nullopt};
  EXPECT_NEAR(lamp_similarity(motorcycle, right_alone), 0.0, kExact);
  EXPECT_NEAR(lamp_similarity(motorcycle, motorcycle), 1.0, kExact);
  EXPECT_EQ(lamp_similarity({}, pair_at(100, 50)), 0.0);
  EXPECT_EQ(lamp_similarity(pair_at(100, 50), {}), 0.0);
}

TEST(Matching, GivesEachVehicleTheTrackThatFollowsItLongest) {
  const std::vector<TruthVehicle> truth{truth_at("a", 100, 0, 99), truth_at("b", 300, 0, 99)};
  // A short track that sits exactly on `a`, a long one slightly off it, one on `b`, one on nothing.
  const std::vector<RunVehicle> run{run_at("1", 100, 0, 9), run_at("2", 104, 10, 99),
                                    run_at("3", 303, 5, 60), run_at("4", 700, 0, 99)};
  const Matching matching = match(truth, run);
  EXPECT_TRUE(matching.by_image);
  EXPECT_EQ(matching.run_of_truth[0], 1U);
  EXPECT_EQ(matching.run_of_truth[1], 2U);
  EXPECT_EQ(matching.duplicate_of[0], 0U);
  EXPECT_EQ(matching.duplicate_of[1], std::nullopt);
  EXPECT_EQ(matching.duplicate_of[3], std::nullopt);
}

TEST(Matching, AVehicleWhoseLongestTrackIsWithheldWasMeasuredByAnother) {
  const std::vector<TruthVehicle> truth{truth_at("a", 100, 0, 99), truth_at("b", 300, 0, 99)};
  // Of `a` a long track without a speed and three short ones, two of them measured; `b` was
  // measured by its longest.
  const std::vector<RunVehicle> run{
      run_at("1", 100, 0, 59),  measured(run_at("2", 100, 60, 69), 6.5, 20.0),
      run_at("3", 100, 70, 74), measured(run_at("4", 100, 75, 99), 9.0, 20.0),
      run_at("5", 300, 0, 39),  measured(run_at("6", 300, 40, 99), 5.0, 20.0)};
  const Matching matching = match(truth, run);
  EXPECT_EQ(matching.run_of_truth[0], 3U);
  EXPECT_EQ(matching.run_of_truth[1], 5U);
  for (const std::size_t second : {0U, 1U, 2U}) EXPECT_EQ(matching.duplicate_of[second], 0U);
  EXPECT_EQ(matching.duplicate_of[3], std::nullopt);
  EXPECT_EQ(matching.duplicate_of[4], 1U);
}

TEST(Matching, ATrackThatSharesItselfOutBelongsToNobody) {
  // A third of the time on each of three vehicles that are all there throughout.
  const std::vector<TruthVehicle> truth{truth_at("a", 100, 0, 29), truth_at("b", 300, 0, 29),
                                        truth_at("c", 500, 0, 29)};
  RunVehicle wanderer = run_at("1", 100, 0, 9);
  for (int frame = 10; frame < 30; ++frame)
    wanderer.sightings.push_back({frame, pair_at(frame < 20 ? 300 : 500, 500), {}, {}});
  const Matching matching = match(truth, std::vector<RunVehicle>{wanderer});
  for (const auto& run : matching.run_of_truth) EXPECT_EQ(run, std::nullopt);
}

TEST(Matching, AGlimpseInCommonIsNotEnough) {
  const std::vector<TruthVehicle> truth{truth_at("a", 100, 0, 29)};
  EXPECT_EQ(match(truth, std::vector<RunVehicle>{run_at("1", 100, 25, 60)}).run_of_truth[0],
            std::nullopt);
  EXPECT_EQ(match(truth, std::vector<RunVehicle>{run_at("1", 100, 15, 44)}).run_of_truth[0], 0U);
}

RunVehicle pass(std::string id, double first_s, double last_s) {
  RunVehicle vehicle;
  vehicle.track_id = std::move(id);
  vehicle.t_first_s = first_s;
  vehicle.t_last_s = last_s;
  return vehicle;
}

TEST(Matching, PassesOfAPhotodiodeAreMatchedByTime) {
  const std::vector<TruthVehicle> truth{truth_at("a", 100, 0, 60), truth_at("b", 100, 20, 80),
                                        truth_at("c", 100, 200, 260)};
  const std::vector<RunVehicle> run{pass("1", 5.0, 7.8), pass("2", 3.0, 5.8),
                                    pass("3", 12.0, 14.0)};
  const Matching matching = match(truth, run);
  EXPECT_FALSE(matching.by_image);
  EXPECT_EQ(matching.run_of_truth[0], 1U);
  EXPECT_EQ(matching.run_of_truth[1], 0U);
  EXPECT_EQ(matching.run_of_truth[2], std::nullopt);
}

TEST(Matching, PassesFollowOneAnotherAsTheVehiclesLeave) {
  // All are in view from the beginning; a pass is noticed only near its end.
  std::vector<TruthVehicle> truth{truth_at("slow", 100, 0, 70), truth_at("fast", 200, 0, 70),
                                  truth_at("medium", 300, 0, 48)};
  for (TruthSighting& sighting : truth[1].sightings) {  // gone past at 2.1 s, truth goes on
    sighting.lamps = {};
    sighting.range_m = 21.0 - 10.0 * sighting.t_s;
  }
  const std::vector<RunVehicle> run{pass("1", 0.9, 2.4), pass("2", 3.2, 5.2), pass("3", 5.6, 7.0)};
  const Matching matching = match(truth, run);
  EXPECT_EQ(matching.run_of_truth[0], 2U);
  EXPECT_EQ(matching.run_of_truth[1], 0U);
  EXPECT_EQ(matching.run_of_truth[2], 1U);
  // The same film backwards: the vehicles drive away.
  std::vector<TruthVehicle> away{truth_at("slow", 100, 0, 70), truth_at("fast", 200, 49, 70)};
  for (TruthVehicle& vehicle : away) vehicle.direction = "receding";
  const Matching backwards =
      match(away, std::vector<RunVehicle>{pass("1", 4.6, 6.1), pass("2", 0.0, 1.4)});
  EXPECT_EQ(backwards.run_of_truth[0], 1U);
  EXPECT_EQ(backwards.run_of_truth[1], 0U);
}

TEST(Matching, RangeDecidesBetweenVehiclesThatAreThereTogether) {
  std::vector<TruthVehicle> truth{truth_at("near", 100, 0, 60), truth_at("far", 100, 0, 60)};
  for (TruthSighting& sighting : truth[0].sightings) sighting.range_m = 20.0;
  for (TruthSighting& sighting : truth[1].sightings) sighting.range_m = 60.0;
  RunVehicle vehicle = measured(pass("1", 1.0, 3.0), 2.0, 20.0);
  for (const auto& [range_m, expected] : {std::pair{24.0, 0}, {52.0, 1}}) {
    vehicle.range_ref_m = range_m;
    const Matching matching = match(truth, std::vector<RunVehicle>{vehicle});
    EXPECT_EQ(matching.run_of_truth[expected], 0U) << range_m;
  }
}

TEST(Matching, PassesWithoutPixelsFillWhatTheCameraLeft) {
  const std::vector<TruthVehicle> truth{truth_at("a", 100, 0, 30), truth_at("b", 300, 0, 60)};
  const std::vector<RunVehicle> run{run_at("1", 100, 0, 30), pass("2", 2.0, 6.0)};
  const Matching matching = match(truth, run);
  EXPECT_EQ(matching.run_of_truth[0], 0U);
  EXPECT_EQ(matching.run_of_truth[1], 1U);
}

TEST(Matching, NothingOnEitherSideMatchesNothing) {
  EXPECT_TRUE(match({}, {}).run_of_truth.empty());
  const std::vector<RunVehicle> run{run_at("1", 100, 0, 9)};
  EXPECT_EQ(match({}, run).duplicate_of.size(), 1U);
  const std::vector<TruthVehicle> truth{truth_at("a", 100, 0, 9)};
  EXPECT_EQ(match(truth, {}).run_of_truth[0], std::nullopt);
}

TEST(TrackingFrames, OccludedTruthCountsNeitherWay) {
  std::vector<TruthVehicle> truth{truth_at("a", 100, 0, 3)};
  truth[0].sightings[1].occluded = truth[0].sightings[2].occluded = true;
  // The run coasts through frame 1, rests in frame 2, and sees a ghost in frame 3.
  std::vector<RunVehicle> run{run_at("1", 100, 0, 3), run_at("2", 900, 3, 3)};
  run[0].sightings.erase(run[0].sightings.begin() + 2);
  const TrackingScores scores = tracking_scores(tracking_frames(truth, run));
  EXPECT_EQ(scores.clear.true_positives, 2);
  EXPECT_EQ(scores.clear.false_negatives, 0);
  EXPECT_EQ(scores.clear.false_positives, 1);
}

}  // namespace
}  // namespace vildar
