#include "estimate/beam_doubt.h"

#include <cmath>

#include <gtest/gtest.h>

namespace vildar {
namespace {

constexpr double kSpeed_mps = 20.0, kAlong_m = 35.0;
constexpr double kEdge_rad = 0.45;

PowerCase case_of() {
  PowerCase known;
  known.law = {1.0, 2.0, 0.0};
  known.log_gain_std = 0.1;
  known.receiver_m = {0.0, 0.0, 4.0};
  known.lateral_m = {-4.0, 0.3};
  known.lamp_height_m = {0.65, 0.05};
  return known;
}

PassMotion motion_of() { return {0.0, kSpeed_mps, kAlong_m, 0.0}; }

// Without noise, from 60 to 10 m; the beam has one cosine of the azimuth.
PowerSeries light_of(int wave, double ripple_nat) {
  PowerSeries series;
  for (double t_s = -1.25; t_s < 1.25; t_s += 1e-3) {
    const double ahead_m = kAlong_m - kSpeed_mps * t_s;
    const double unlike = ripple_nat * std::cos(wave * kPi * std::atan2(4.0, ahead_m) / kEdge_rad);
    series.time_s.push_back(t_s);
    series.power_w.push_back(std::exp(unlike) / (ahead_m * ahead_m + 4.0 * 4.0 + 3.35 * 3.35));
  }
  return series;
}

double mean_power_w(const PowerSeries& series) {
  double sum_w = 0.0;
  for (const double power_w : series.power_w) sum_w += power_w;
  return sum_w;
}

TEST(BeamDoubt, LampsOfTheLawLeaveNone) {
  const auto ripple = beam_ripple_nat(light_of(1, 0.0), case_of(), motion_of());
  ASSERT_TRUE(ripple);
  EXPECT_LE(*ripple, 0.02);
}

TEST(BeamDoubt, GrowsWithWhatTheLightShows) {
  const auto little = beam_ripple_nat(light_of(3, 0.03), case_of(), motion_of());
  const auto much = beam_ripple_nat(light_of(3, 0.15), case_of(), motion_of());
  ASSERT_TRUE(little && much);
  EXPECT_GT(*much, 2.0 * *little);
  EXPECT_GT(*much, 0.1);
}

// What a cosine adds throughout is in K, what it changes while the vehicle comes is not.
TEST(BeamDoubt, GrowsWhereTheGainWasFittedToTheLight) {
  constexpr double kRipple_nat = 0.4;
  PowerCase fitted = case_of();
  fitted.exponent_std = 0.1;
  fitted.log_gain_per_exponent = 3.0;
  for (const double reference_s : {-1.0, 0.0, 1.0}) {
    PassMotion start = motion_of();
    start.reference_s = reference_s;
    start.along_m -= kSpeed_mps * reference_s;
    const auto ripple = beam_ripple_nat(light_of(3, kRipple_nat), fitted, start);
    ASSERT_TRUE(ripple);
    EXPECT_GT(*ripple, kRipple_nat);
  }
}

// Of the total light the pull of each cosine is its mean, weighted with the light.
TEST(BeamDoubt, AddsThePullsInQuadrature) {
  constexpr double kRipple_nat = 0.2;
  constexpr double kCurvature = 1e-3;  // of exp over a hundredth of a nat
  const PowerSeries series = light_of(1, 0.0);
  double expected = 0.0;
  for (int k = 1; k <= 6; ++k) {
    double pull_w = 0.0;
    for (std::size_t i = 0; i < series.time_s.size(); ++i)
      pull_w +=
          series.power_w[i] *
          std::cos(k * kPi * std::atan2(4.0, kAlong_m - kSpeed_mps * series.time_s[i]) / kEdge_rad);
    expected += std::pow(pull_w * kRipple_nat / k, 2);
  }
  const double found = beam_variance(series, case_of(), motion_of(), kRipple_nat, mean_power_w);
  EXPECT_NEAR(found / expected, 1.0, kCurvature);
}

// Where K was fitted to the light itself, what a cosine adds throughout is in K.
TEST(BeamDoubt, SparesAGainThatWasFitted) {
  PowerCase fitted = case_of();
  fitted.log_gain_per_exponent = 3.0;
  const auto log_mean = [](const PowerSeries& series) {
    double sum = 0.0;
    for (const double power_w : series.power_w) sum += std::log(power_w);
    return sum / static_cast<double>(series.power_w.size());
  };
  constexpr double kRounding = 1e-9;
  const PowerSeries series = light_of(1, 0.0);
  EXPECT_LT(beam_variance(series, fitted, motion_of(), 0.2, log_mean), kRounding);
  EXPECT_GT(beam_variance(series, case_of(), motion_of(), 0.2, log_mean), 1e-3);
}

TEST(BeamDoubt, SaysNothingOfAMoment) {
  PowerSeries series = light_of(1, 0.0);
  series.time_s.resize(60);
  series.power_w.resize(60);
  EXPECT_FALSE(beam_ripple_nat(series, case_of(), motion_of()));
  EXPECT_TRUE(std::isinf(
      beam_variance(series, case_of(), motion_of(), 0.1, [](const PowerSeries&) { return NAN; })));
}

}  // namespace
}  // namespace vildar
