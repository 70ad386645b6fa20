#include "estimate/beam_doubt.h"

#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "law_pass.h"

namespace vildar {
namespace {

using namespace law_pass;

double mean_power_w(const PowerSeries& series) {
  double sum_w = 0.0;
  for (const double power_w : series.power_w) sum_w += power_w;
  return sum_w;
}

// Of the total light the pull of each shape is its mean, weighted with the light.
TEST(BeamDoubt, AddsThePullsInQuadrature) {
  constexpr double kRipple_nat = 0.2;
  constexpr double kCurvature = 1e-3;  // of exp over a hundredth of a nat
  const PowerSeries series = light_of(1, 0.0);
  const auto pull_w = [&](const std::function<double(double ahead_m)>& shape) {
    double sum_w = 0.0;
    for (std::size_t i = 0; i < series.time_s.size(); ++i)
      sum_w += series.power_w[i] * shape(kAlong_m - kSpeed_mps * series.time_s[i]);
    return sum_w;
  };
  const auto azimuth = [](double ahead_m) { return std::atan2(4.0, ahead_m); };
  double expected = 0.0;
  for (int k = 1; k <= 6; ++k)
    expected += std::pow(kRipple_nat / k * pull_w([&](double ahead_m) {
                           return std::cos(k * kPi * azimuth(ahead_m) / kEdge_rad);
                         }),
                         2);
  const double wide_w = pull_w([&](double ahead_m) { return std::pow(azimuth(ahead_m), 2); });
  const double raised_w =
      pull_w([](double ahead_m) { return std::atan2(3.35, std::hypot(ahead_m, 4.0)); });
  expected += std::pow(4.0 * kRipple_nat, 2) * (wide_w * wide_w + raised_w * raised_w);
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

// As headlamps differ, by 4 nat per radian of elevation and per squared radian of azimuth, though
// the light itself follows the law.
TEST(BeamDoubt, OfLampsOfWhichNothingIsTold) {
  PowerCase fitted = case_of();
  fitted.log_gain_per_exponent = 3.0;
  const PowerSeries series = light_of(1, 0.0);
  const auto log_rise = [](const PowerSeries& seen) {
    return std::log(seen.power_w.back() / seen.power_w.front());
  };
  const auto risen = [&](const std::function<double(double ahead_m)>& shape) {
    return shape(kAlong_m - kSpeed_mps * series.time_s.back()) -
           shape(kAlong_m - kSpeed_mps * series.time_s.front());
  };
  const double wide = risen([](double ahead_m) { return std::pow(std::atan2(4.0, ahead_m), 2); });
  const double raised =
      risen([](double ahead_m) { return std::atan2(3.35, std::hypot(ahead_m, 4.0)); });
  constexpr double kRounding = 1e-6;
  const double found = beam_variance(series, fitted, motion_of(), 0.0, log_rise);
  EXPECT_NEAR(found, 16.0 * (wide * wide + raised * raised), kRounding);
  EXPECT_EQ(beam_variance(series, case_of(), motion_of(), 0.0, log_rise), 0.0);
}

TEST(BeamDoubt, IsInfiniteWhereTheEstimatorGivesNothing) {
  const PowerSeries series = light_of(1, 0.0);
  EXPECT_TRUE(std::isinf(
      beam_variance(series, case_of(), motion_of(), 0.1, [](const PowerSeries&) { return NAN; })));
}

}  // namespace
}  // namespace vildar
