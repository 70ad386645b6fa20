#include "calib/site/spreads.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/random.h"

namespace vildar {
namespace {

// A pass that tells one quantity with a given variance.
LinearPass measured(double value, double variance) {
  LinearPass pass;
  pass.information = Eigen::MatrixXd::Constant(1, 1, 1.0 / variance);
  pass.gradient = Eigen::VectorXd::Zero(1);
  pass.shared_by_path = Eigen::MatrixXd::Ones(1, 1);
  pass.shared = Eigen::VectorXd::Constant(1, value);
  pass.members = {{0, 0.0}};
  return pass;
}

Population vague(double likely_spread, double weight) {
  Population population;
  population.key = "lamps.height_m";
  population.mean = {0.0, 1e4};
  population.likely_spread = population.spread = likely_spread;
  population.spread_weight = weight;
  return population;
}

TEST(Spreads, ExactValuesGiveTheirMeanAndTheirSampleVariance) {
  // With values known exactly the fixed point has a closed form: the prior's weight times its
  // square and the sum of squares, over weight and passes less the one that the mean takes.
  const std::vector<double> values{0.61, 0.70, 0.55, 0.83, 0.66};
  std::vector<LinearPass> passes;
  double mean = 0.0, squares = 0.0;
  for (const double value : values) {
    passes.push_back(measured(value, 1e-12));
    mean += value / static_cast<double>(values.size());
  }
  for (const double value : values) squares += (value - mean) * (value - mean);
  std::vector<Population> populations{vague(0.2, 4.0)};
  const Learned learned = learn_spreads(passes, populations);
  const double spread = std::sqrt((4.0 * 0.2 * 0.2 + squares) / (4.0 + 5.0 - 1.0));
  EXPECT_NEAR(learned.means[0], mean, 1e-6);
  EXPECT_NEAR(populations[0].spread / spread, 1.0, 0.01);  // steps end at a tenth of that
  EXPECT_NEAR(learned.covariance(0, 0) / (spread * spread / 5.0), 1.0, 0.02);
}

TEST(Spreads, PassesThatTellLittleDoNotPoseAsSpread) {
  // True spread nought, own sigmas ten times the likely spread.
  Random random(5);
  std::vector<LinearPass> passes;
  for (int i = 0; i < 200; ++i) passes.push_back(measured(random.normal(), 1.0));
  std::vector<Population> populations{vague(0.1, 1.0)};
  const Learned learned = learn_spreads(passes, populations);
  EXPECT_LT(populations[0].spread, 0.35);  // of the 1.0 that the values scatter by
  EXPECT_LT(std::abs(learned.means[0]), 4.0 * std::sqrt(learned.covariance(0, 0)));
}

TEST(Spreads, NamesTheOneThatIsUnlikeTheOthers) {
  Random random(6);
  std::vector<LinearPass> passes;
  for (int i = 0; i < 20; ++i) passes.push_back(measured(random.normal(0.7, 0.05), 1e-6));
  std::vector<Population> populations{vague(0.05, 4.0)};
  EXPECT_FALSE(stranger(passes, learn_spreads(passes, populations), populations));
  passes[7].shared[0] = 1.4;
  EXPECT_EQ(stranger(passes, learn_spreads(passes, populations), populations), 7U);
}

}  // namespace
}  // namespace vildar
