#include "simulate/pass.h"

#include <gtest/gtest.h>

#include "core/random.h"
#include "estimate/curved_angle.h"

namespace vildar::simulate {
namespace {

Options quick(int trials) {
  Options options;
  options.trials = trials;
  options.maximum_likelihood = false;
  return options;
}

// Generator with the cosine, estimator without, 30 dB electrical, label at the window's end.
TEST(StraightPass, AccuracyFallsBelowNinetyPercentWhereKnown) {
  for (const auto& [duration_s, limit_deg] :
       {std::pair{0.1, 21.0}, {0.2, 33.3}, {0.3, 47.4}, {0.4, 59.0}, {0.5, 66.3}}) {
    Pass pass = straight_pass(quick(100), true);
    pass.duration_s = duration_s;
    const PassScores scores = score_pass(pass, quick(100), 1);
    EXPECT_NEAR(last_above(scores.incidence_deg, scores.accuracy_percent, 90.0), limit_deg, 1.0)
        << duration_s;
  }
}

TEST(StraightPass, WithoutTheCosineAccuracyOnlyRises) {
  const PassScores scores = score_pass(straight_pass(quick(100), false), quick(100), 2);
  EXPECT_GT(scores.accuracy_percent.front(), 98.0);
  EXPECT_GT(scores.accuracy_percent.back(), 99.5);
  EXPECT_GT(scores.incidence_deg.back(), 85.0);
  for (const double missing : scores.missing) EXPECT_EQ(missing, 0.0);
}

TEST(StraightPass, LabelsShiftByTheWindow) {
  Options options = quick(2);
  const PassScores end = score_pass(straight_pass(options, false), options, 3);
  options.label = WindowLabel::start;
  const PassScores start = score_pass(straight_pass(options, false), options, 3);
  options.label = WindowLabel::centre;
  const PassScores centre = score_pass(straight_pass(options, false), options, 3);
  EXPECT_EQ(end.accuracy_percent, start.accuracy_percent);
  EXPECT_NEAR(start.time_s.front(), 0.0, 1e-12);
  EXPECT_NEAR(centre.time_s.front(), 0.1495, 1e-12);
  EXPECT_NEAR(end.time_s.front(), 0.299, 1e-12);
}

TEST(CurvedPass, StartAccuracyIsTheKnownOne) {
  constexpr int kTrials = 1000;
  const PassScores scores = score_pass(curved_pass(quick(kTrials), false), quick(kTrials), 4, true);
  EXPECT_NEAR(scores.accuracy_percent.front(), 87.0, 2.0);
}

// The sliding sums of the curved road against the estimator itself on each window.
TEST(CurvedPass, SlidingAgreesWithTheWholeFit) {
  Options options = quick(2);
  Pass pass = curved_pass(options, true);
  pass.sigma_w = 0.0;
  const PassScores scores = score_pass(pass, options, 5);
  for (std::size_t i = 0; i < scores.rmse_percent.size(); i += 100)
    EXPECT_NEAR(scores.rmse_percent[i], 0.0, 1e-5) << i;
}

TEST(Pass, MaximumLikelihoodStaysNearTheBoundWhereThePaperDoesNot) {
  Options options = quick(100);
  options.maximum_likelihood = true;
  const PassScores scores = score_pass(straight_pass(options, true), options, 6);
  ASSERT_EQ(scores.ml_rmse_percent.size(), scores.bound_percent.size());
  for (std::size_t i = 0; i < scores.bound_percent.size(); ++i)  // four sigmas at 100 trials: 28 %
    EXPECT_NEAR(scores.ml_rmse_percent[i] / scores.bound_percent[i], 1.0, 0.28) << i;
  EXPECT_GT(scores.rmse_percent.back(), 100.0 * scores.ml_rmse_percent.back());
}

TEST(Pass, NumbersDoNotDependOnTheThreads) {
  Options options = quick(20);
  options.maximum_likelihood = true;
  options.threads = 1;
  const PassScores one = score_pass(straight_pass(options, true), options, 7);
  options.threads = 3;
  const PassScores three = score_pass(straight_pass(options, true), options, 7);
  EXPECT_EQ(one.rmse_percent, three.rmse_percent);
  EXPECT_EQ(one.ml_rmse_percent, three.ml_rmse_percent);
  options.seed = 2;
  EXPECT_NE(one.rmse_percent, score_pass(straight_pass(options, true), options, 7).rmse_percent);
}

TEST(Pass, LastAboveStopsAtTheFirstFall) {
  EXPECT_DOUBLE_EQ(last_above({0.0, 1.0, 2.0, 3.0}, {100.0, 95.0, 85.0, 95.0}, 90.0), 1.0);
  EXPECT_DOUBLE_EQ(last_above({3.0, 4.0}, {80.0, 95.0}, 90.0), 3.0);
  EXPECT_DOUBLE_EQ(last_above({3.0, 4.0}, {95.0, 95.0}, 90.0), 4.0);
}

}  // namespace
}  // namespace vildar::simulate
