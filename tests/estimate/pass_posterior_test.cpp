#include "estimate/pass_posterior.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "core/random.h"
#include "law_pass.h"
#include "support/trials.h"

namespace vildar {
namespace {

using namespace law_pass;

std::optional<PassPosterior> found_of(const Outcome<PassPosterior>& outcome) {
  const auto* found = std::get_if<PassPosterior>(&outcome);
  return found ? std::optional(*found) : std::nullopt;
}

TEST(PassPosterior, LampsOfTheLawLeaveNoDoubtOfThem) {
  PowerCase known = case_of();
  known.log_gain_std = 0.0;
  const auto ripple = found_of(pass_posterior(light_of(1, 0.0), known, motion_of()));
  ASSERT_TRUE(ripple);
  EXPECT_LE(ripple->ripple_nat, 0.02);
}

TEST(PassPosterior, LampsThatDifferInGainAreNotOfTheLaw) {
  PowerCase known = case_of();
  known.log_gain_std = 0.4;
  const auto ripple = found_of(pass_posterior(light_of(1, 0.0), known, motion_of()));
  ASSERT_TRUE(ripple);
  EXPECT_GE(ripple->ripple_nat, 0.06);
}

TEST(PassPosterior, DoubtOfLampsGrowsWithWhatTheLightShows) {
  const auto little = found_of(pass_posterior(light_of(3, 0.03), case_of(), motion_of()));
  const auto much = found_of(pass_posterior(light_of(3, 0.15), case_of(), motion_of()));
  ASSERT_TRUE(little && much);
  EXPECT_GT(much->ripple_nat, 2.0 * little->ripple_nat);
  EXPECT_GT(much->ripple_nat, 0.1);
}

// What a cosine adds throughout is in K, what it changes while the vehicle comes is not.
TEST(PassPosterior, DoubtOfLampsGrowsWhereTheGainWasFittedToTheLight) {
  constexpr double kRipple_nat = 0.4;
  PowerCase fitted = case_of();
  fitted.exponent_std = 0.1;
  fitted.log_gain_per_exponent = 3.0;
  for (const double reference_s : {-1.0, 0.0, 1.0}) {
    PassMotion start = motion_of();
    start.reference_s = reference_s;
    start.along_m -= kSpeed_mps * reference_s;
    const auto ripple = found_of(pass_posterior(light_of(3, kRipple_nat), fitted, start));
    ASSERT_TRUE(ripple);
    EXPECT_GT(ripple->ripple_nat, kRipple_nat);
  }
}

TEST(PassPosterior, SaysNothingOfAMoment) {
  const PowerSeries whole = light_of(1, 0.0);
  for (const std::size_t samples : {0U, 1U, 3U, 40U}) {
    PowerSeries series = whole;
    series.time_s.resize(samples);
    series.power_w.resize(samples);
    series.background_std_w = whole.power_w.front();
    EXPECT_EQ(std::get<Miss>(pass_posterior(series, case_of(), motion_of())), Miss::outside_model);
    EXPECT_EQ(std::get<Miss>(pass_posterior(series, case_of())), Miss::outside_model);
  }
}

// All the light that lies between the least of it and none may be the background's.
TEST(PassPosterior, TellsTheBackground) {
  constexpr double kShare = 0.7;  // of the least light
  PowerCase known = case_of();
  known.log_gain_std = known.lateral_m.std = known.lamp_height_m.std = 0.0;
  PowerSeries series = light_of(1, 0.0);
  const double least_w = *std::ranges::min_element(series.power_w);
  for (double& power_w : series.power_w) power_w += (kShare - 0.5) * least_w;
  series.background_std_w = 0.5 * least_w;
  const auto found = found_of(pass_posterior(series, known));
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->background_w, (kShare - 0.5) * least_w, 2.0 * found->background_std_w);
  EXPECT_LT(found->background_std_w, 0.2 * series.background_std_w);
  EXPECT_NEAR(found->motion.speed_mps / kSpeed_mps, 1.0, 2.0 * found->log_speed_std);
}

// Lamps, lengths, gain and background drawn from what is known of them.
TEST(PassPosterior, OneSigmaCoversTheSpeedAboutTwoTimesInThree) {
  constexpr int kTrials = trials(100);
  constexpr double kShare = 0.683;
  const double slack = 4.0 * std::sqrt(kShare * (1.0 - kShare) / kTrials);
  const PowerCase told = case_of();
  Random random(20261125);
  int covered = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const double gain = std::exp(random.normal(0.0, told.log_gain_std));
    const double across_m = random.normal(4.0, told.lateral_m.std);
    const double below_m = 4.0 - random.normal(told.lamp_height_m.mean, told.lamp_height_m.std);
    const double first_nat = random.normal(0.0, 0.1), second_nat = random.normal(0.0, 0.05);
    PowerSeries series = light_of(1, 0.0);
    const double noise_w = 0.01 * series.power_w.front();
    series.background_std_w = 0.5 * series.power_w.front();
    const double background_w = random.normal(0.0, series.background_std_w);
    for (std::size_t i = 0; i < series.time_s.size(); ++i) {
      const double ahead_m = kAlong_m - kSpeed_mps * series.time_s[i];
      const double turn = kPi * std::atan2(across_m, ahead_m) / kEdge_rad;
      series.power_w[i] =
          gain * std::exp(first_nat * std::cos(turn) + second_nat * std::cos(2.0 * turn)) /
              (ahead_m * ahead_m + across_m * across_m + below_m * below_m) +
          background_w + random.normal(0.0, noise_w);
    }
    const auto found = found_of(pass_posterior(series, told));
    ASSERT_TRUE(found) << trial;
    covered += std::abs(std::log(found->motion.speed_mps / kSpeed_mps)) < found->log_speed_std;
  }
  EXPECT_NEAR(covered / static_cast<double>(kTrials), kShare, slack);
}

// One sigma less of the exponent, or more of ln K, is no law any more.
TEST(PowerSpeed, ALawThatTheSiteLeavesOpenGivesNoSpeed) {
  PowerCase exponent = case_of(), gain = case_of();
  exponent.exponent_std = 2.0;
  gain.log_gain_std = 1e3;
  for (const PowerCase& known : {exponent, gain})
    EXPECT_EQ(std::get<Miss>(power_speed(light_of(1, 0.0), known)), Miss::too_uncertain);
}

}  // namespace
}  // namespace vildar
