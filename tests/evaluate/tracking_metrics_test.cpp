#include "evaluate/tracking_metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "evaluate/hand_made.h"
#include "evaluate/mot_challenge.h"
#include "support/shared_data.h"

namespace vildar {
namespace {

// Presence of each id and similarity of each pair over time; the pairs not named have none.
struct Hand {
  std::vector<std::vector<int>> truth_present, run_present;  // [id][frame]
  struct Pair {
    int truth, run;
    std::vector<double> similarity;  // [frame]
  };
  std::vector<Pair> pairs;

  std::vector<TrackingFrame> frames() const {
    std::vector<TrackingFrame> result(truth_present.front().size());
    for (std::size_t t = 0; t < result.size(); ++t) {
      TrackingFrame& frame = result[t];
      for (std::size_t id = 0; id < truth_present.size(); ++id)
        if (truth_present[id][t]) frame.truth_ids.push_back(static_cast<int>(id));
      for (std::size_t id = 0; id < run_present.size(); ++id)
        if (run_present[id][t]) frame.run_ids.push_back(static_cast<int>(id));
      frame.similarity.setZero(std::ssize(frame.truth_ids), std::ssize(frame.run_ids));
      for (std::size_t i = 0; i < frame.truth_ids.size(); ++i)
        for (std::size_t j = 0; j < frame.run_ids.size(); ++j)
          for (const Pair& pair : pairs)
            if (pair.truth == frame.truth_ids[i] && pair.run == frame.run_ids[j])
              frame.similarity(i, j) = pair.similarity[t];
    }
    return result;
  }
};

// The three cases of TrackEval's own tests, counted by hand there.
Hand no_confusion() {
  return {{{1, 1, 1, 1, 1}, {1, 1, 1, 0, 0}},
          {{1, 1, 1, 1, 0}, {1, 1, 1, 1, 1}},
          {{0, 1, {0, 0, 0, 1, 1}}, {1, 0, {1, 1, 0, 0, 0}}}};
}

TEST(TrackingMetrics, CountsTheCaseWithoutConfusion) {
  const TrackingScores scores = tracking_scores(no_confusion().frames());
  EXPECT_EQ(scores.clear.true_positives, 4);
  EXPECT_EQ(scores.clear.false_negatives, 4);
  EXPECT_EQ(scores.clear.false_positives, 5);
  EXPECT_EQ(scores.clear.id_switches, 0);
  EXPECT_NEAR(scores.clear.mota(), -0.125, kExact);
  EXPECT_NEAR(scores.identity.recall(), 4.0 / 8.0, kExact);
  EXPECT_NEAR(scores.identity.precision(), 4.0 / 9.0, kExact);
  EXPECT_NEAR(scores.identity.idf1(), 8.0 / 17.0, kExact);
}

TEST(TrackingMetrics, CountsTheCaseWithConfusion) {
  Hand hand = no_confusion();
  hand.pairs.push_back({0, 0, {0, 0, 1, 0, 0}});
  hand.pairs.push_back({1, 1, {0, 1, 0, 0, 0}});
  const TrackingScores scores = tracking_scores(hand.frames());
  EXPECT_EQ(scores.clear.true_positives, 5);
  EXPECT_EQ(scores.clear.false_negatives, 3);
  EXPECT_EQ(scores.clear.false_positives, 4);
  EXPECT_EQ(scores.clear.id_switches, 1);
  EXPECT_NEAR(scores.clear.mota(), 0.0, kExact);
  EXPECT_EQ(scores.identity.true_positives, 4);
  EXPECT_NEAR(scores.identity.idf1(), 8.0 / 17.0, kExact);
}

TEST(TrackingMetrics, CountsTheCaseOfSplitTracks) {
  const Hand hand{
      {{1, 1, 0, 1, 1}, {1, 1, 1, 1, 1}},
      {{1, 1, 0, 0, 0}, {0, 0, 1, 1, 1}, {0, 0, 0, 0, 1}, {0, 0, 1, 1, 1}, {1, 1, 0, 0, 0}},
      {{0, 0, {1, 1, 0, 0, 0}},
       {0, 3, {0, 0, 0, 1, 1}},
       {1, 1, {0, 0, 1, 1, 0}},
       {1, 2, {0, 0, 0, 0, 1}},
       {1, 4, {1, 1, 0, 0, 0}}}};
  const TrackingScores scores = tracking_scores(hand.frames());
  EXPECT_EQ(scores.clear.true_positives, 9);
  EXPECT_EQ(scores.clear.false_negatives, 0);
  EXPECT_EQ(scores.clear.false_positives, 2);
  EXPECT_EQ(scores.clear.id_switches, 3);
  EXPECT_NEAR(scores.clear.mota(), 4.0 / 9.0, kExact);
  EXPECT_NEAR(scores.identity.idf1(), 8.0 / 20.0, kExact);
}

TEST(TrackingMetrics, OneVehicleInTwoHalvesScoresAsByHand) {
  // Truth over 4 frames; the run has two tracks of 2 frames with similarity 0.8. Up to the
  // threshold 0.80 (16 of 19) all 4 are found: DetA 1, AssA 2 / (4 + 2 - 2) = 0.5, HOTA sqrt(0.5).
  const Hand hand{{{1, 1, 1, 1}},
                  {{1, 1, 0, 0}, {0, 0, 1, 1}},
                  {{0, 0, {0.8, 0.8, 0, 0}}, {0, 1, {0, 0, 0.8, 0.8}}}};
  const TrackingScores scores = tracking_scores(hand.frames());
  EXPECT_NEAR(mean_of(scores.hota.hota()), 16.0 / 19.0 * std::sqrt(0.5), kExact);
  EXPECT_NEAR(mean_of(scores.hota.detection_accuracy()), 16.0 / 19.0, kExact);
  EXPECT_NEAR(mean_of(scores.hota.association_accuracy), 16.0 / 19.0 * 0.5, kExact);
  EXPECT_NEAR(mean_of(scores.hota.localisation), (16.0 * 0.8 + 3.0) / 19.0, kExact);
  EXPECT_NEAR(scores.clear.motp(), 0.8, kExact);
  EXPECT_EQ(scores.clear.id_switches, 1);
  EXPECT_EQ(scores.clear.fragmentations, 0);
}

TEST(TrackingMetrics, NothingSeenAndNothingThereAreCounted) {
  TrackingFrame missed, ghost, empty;
  missed.truth_ids = {3, 9};
  ghost.run_ids = {5};
  const std::vector<TrackingFrame> frames{missed, ghost, empty};
  const TrackingScores scores = tracking_scores(frames);
  EXPECT_EQ(scores.clear.false_negatives, 2);
  EXPECT_EQ(scores.clear.false_positives, 1);
  EXPECT_EQ(scores.clear.mostly_lost, 2);
  EXPECT_EQ(scores.clear.frames, 3);
  EXPECT_EQ(mean_of(scores.hota.hota()), 0.0);
  EXPECT_EQ(scores.identity.idf1(), 0.0);
  EXPECT_NO_THROW(tracking_scores({}));
}

TEST(TrackingMetrics, RefusesASimilarityThatDoesNotFit) {
  TrackingFrame frame;
  frame.truth_ids = {1, 2};
  frame.run_ids = {1};
  frame.similarity.setOnes(1, 2);
  EXPECT_THROW(tracking_scores(std::span(&frame, 1)), std::invalid_argument);
}

class AgainstTrackEval : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = shared_folder() / "data" / "tracking_metrics";
    if (!std::filesystem::exists(folder_))
      GTEST_SKIP() << "no reference data at " << folder_ << "; set VILDAR_SHARED";
  }

  TrackingScores scores(const std::string& tracker, const std::string& sequence, int frames) const {
    return tracking_scores(mot_sequence(
        folder_ / "gt/mot_challenge/NIGHT-train" / sequence / "gt/gt.txt",
        folder_ / "trackers/mot_challenge/NIGHT-train" / tracker / "data" / (sequence + ".txt"),
        frames));
  }

  std::filesystem::path folder_;
};

void expect_equal(const TrackingScores& scores, const nlohmann::json& expected,
                  const std::string& sequence) {
  constexpr double kSame = 1e-9;  // order of summation
  const auto curve = [&](const char* name, const HotaScores::Curve& ours) {
    const auto theirs = expected.at(std::string("HOTA.") + name).get<std::vector<double>>();
    ASSERT_EQ(theirs.size(), ours.size());
    for (std::size_t a = 0; a < ours.size(); ++a)
      EXPECT_NEAR(ours[a], theirs[a], kSame) << sequence << ' ' << name << ' ' << a;
  };
  const auto value = [&](const char* name, double ours) {
    EXPECT_NEAR(ours, expected.at(name).get<double>(), kSame) << sequence << ' ' << name;
  };
  const HotaScores& hota = scores.hota;
  curve("HOTA", hota.hota());
  curve("DetA", hota.detection_accuracy());
  curve("DetRe", hota.detection_recall());
  curve("DetPr", hota.detection_precision());
  curve("AssA", hota.association_accuracy);
  curve("AssRe", hota.association_recall);
  curve("AssPr", hota.association_precision);
  curve("LocA", hota.localisation);
  curve("HOTA_TP", hota.true_positives);
  curve("HOTA_FN", hota.false_negatives);
  curve("HOTA_FP", hota.false_positives);
  const ClearScores& clear = scores.clear;
  value("CLEAR.MOTA", clear.mota());
  value("CLEAR.MOTP", clear.motp());
  value("CLEAR.CLR_TP", static_cast<double>(clear.true_positives));
  value("CLEAR.CLR_FN", static_cast<double>(clear.false_negatives));
  value("CLEAR.CLR_FP", static_cast<double>(clear.false_positives));
  value("CLEAR.IDSW", static_cast<double>(clear.id_switches));
  value("CLEAR.Frag", static_cast<double>(clear.fragmentations));
  value("CLEAR.MT", static_cast<double>(clear.mostly_tracked));
  value("CLEAR.PT", static_cast<double>(clear.partly_tracked));
  value("CLEAR.ML", static_cast<double>(clear.mostly_lost));
  value("CLEAR.CLR_Frames", static_cast<double>(clear.frames));
  value("Identity.IDF1", scores.identity.idf1());
  value("Identity.IDR", scores.identity.recall());
  value("Identity.IDP", scores.identity.precision());
  value("Identity.IDTP", static_cast<double>(scores.identity.true_positives));
  value("Identity.IDFN", static_cast<double>(scores.identity.false_negatives));
  value("Identity.IDFP", static_cast<double>(scores.identity.false_positives));
}

TEST_F(AgainstTrackEval, EveryNumberOfTheDegradedTrackerIsTheSame) {
  std::ifstream stream(folder_ / "expected_trackeval_12c8791.json");
  const nlohmann::json expected = nlohmann::json::parse(stream);
  const std::vector<TrackingScores> sequences{scores("degraded", "NIGHT-01", 200),
                                              scores("degraded", "NIGHT-02", 300),
                                              scores("degraded", "NIGHT-03", 100)};
  expect_equal(sequences[0], expected.at("NIGHT-01"), "NIGHT-01");
  expect_equal(sequences[1], expected.at("NIGHT-02"), "NIGHT-02");
  expect_equal(sequences[2], expected.at("NIGHT-03"), "NIGHT-03");
  expect_equal(combined(sequences), expected.at("COMBINED_SEQ"), "combined");
}

TEST_F(AgainstTrackEval, ASortRunScoresAsQuoted) {
  constexpr double kQuoted = 0.5e-4;  // four digits
  const std::vector<TrackingScores> sequences{scores("sort", "NIGHT-01", 200),
                                              scores("sort", "NIGHT-02", 300),
                                              scores("sort", "NIGHT-03", 100)};
  const TrackingScores all = combined(sequences);
  EXPECT_NEAR(mean_of(sequences[0].hota.hota()), 0.8165, kQuoted);
  EXPECT_NEAR(mean_of(sequences[1].hota.hota()), 0.6737, kQuoted);
  EXPECT_NEAR(mean_of(all.hota.hota()), 0.7389, kQuoted);
  EXPECT_NEAR(all.clear.mota(), 0.8558, kQuoted);
  EXPECT_NEAR(all.identity.idf1(), 0.9205, kQuoted);
  EXPECT_EQ(all.clear.id_switches, 7);
}

}  // namespace
}  // namespace vildar
