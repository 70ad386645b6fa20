#include "estimate/power_bound.h"

#include <gtest/gtest.h>

#include "estimate/power_pass.h"

namespace vildar {
namespace {

using namespace power_pass;

struct Unknowns {
  const char* name;
  std::vector<PowerParameter> extra;
};

std::variant<PowerMatrix, PowerRefusal> bound_of(const Window& window, double cosine,
                                                 const std::vector<PowerParameter>& extra,
                                                 double snr_db = 40.0) {
  const double sigma = sigma_w(snr_db);
  const Samples samples = straight_window(window, cosine);
  PowerProblem problem = straight_problem(samples, cosine, sigma);
  for (const PowerParameter p : extra) problem.known[p].reset();
  return power_bound(samples.time_s, sigma, straight_truth(window.from_m), problem.known,
                     problem.setting);
}

double percent(const std::variant<PowerMatrix, PowerRefusal>& bound) {
  return 100.0 * std::sqrt(std::get<PowerMatrix>(bound)(kPowerSpeed, kPowerSpeed)) / kSpeed_mps;
}

// Independent numbers by central differences and another matrix library, two to three digits.
TEST(PowerBound, TheTableOfThePaperPass) {
  const Window tenth{"15 to 13 m", 15.0, 13.0, 0.0}, whole{"15 to 1 m", 15.0, 1.0, 0.0};
  const auto expect = [](double value, double expected) {
    EXPECT_NEAR(value / expected, 1.0, 0.03);
  };
  expect(percent(bound_of(tenth, 0.0, {})), 1.85);
  expect(percent(bound_of(kWindows[0], 0.0, {})), 0.248);
  expect(percent(bound_of(kWindows[0], kCosine, {})), 0.249);
  expect(percent(bound_of(kWindows[0], 0.0, {kPowerPerpendicular})), 1.87);
  expect(percent(bound_of(kWindows[0], 0.0, {kPowerExponent})), 12.5);
  expect(percent(bound_of(kWindows[0], 0.0, {kPowerAcceleration})), 1.12);
  expect(percent(bound_of(kWindows[1], kCosine, {})), 0.087);
  expect(percent(bound_of(whole, 0.0, {kPowerLogGain})), 0.39);
  expect(percent(bound_of(whole, kCosine, {kPowerLogGain})), 0.033);
  expect(percent(bound_of(whole, 0.0, {})), 0.0146);
  // Ten times the noise, ten times the bound.
  expect(percent(bound_of(kWindows[0], 0.0, {}, 20.0)), 2.48);
}

TEST(PowerBound, UnknownGainIsHopelessFarAwayAndTogetherWithDistanceImpossible) {
  EXPECT_GT(percent(bound_of(kWindows[0], 0.0, {kPowerLogGain})),
            100.0 * percent(bound_of(kWindows[0], 0.0, {})));
  const auto refused = bound_of(kWindows[0], 0.0, {kPowerLogGain, kPowerPerpendicular});
  EXPECT_EQ(std::get<PowerRefusal>(refused).miss, Miss::unobservable);
  EXPECT_EQ(std::get<PowerRefusal>(refused).reason,
            "speed is not observable: K and d both unknown");
}

// var(V)/V^2 = var(shape) + 1 / [(d/sigma_d)^2 + (gamma/sigma_lnK)^2]: the scale is known from
// metric priors alone.
TEST(PowerBound, PriorsAddAsMeasurementsOfTheScale) {
  const double sigma = sigma_w(60.0);
  const Samples samples = straight_window(kWindows[3], 0.0);
  const auto relative_variance = [&](std::optional<Uncertain> d,
                                     std::optional<Uncertain> log_gain) {
    PowerProblem problem = straight_problem(samples, 0.0, sigma);
    problem.known[kPowerPerpendicular] = d;
    problem.known[kPowerLogGain] = log_gain;
    const auto bound = std::get<PowerMatrix>(
        power_bound(samples.time_s, sigma, straight_truth(15.0), problem.known, problem.setting));
    return bound(kPowerSpeed, kPowerSpeed) / (kSpeed_mps * kSpeed_mps);
  };
  const Uncertain d{0.5, 0.04}, log_gain{0.0, 0.1};
  const double from_d = std::pow(0.5 / 0.04, 2.0), from_gain = std::pow(1.21 / 0.1, 2.0);
  // The shape alone: what is left where the scale is all but exact.
  const double shape = relative_variance(Uncertain{0.5, 1e-7}, std::nullopt);
  EXPECT_NEAR(relative_variance(d, std::nullopt), shape + 1.0 / from_d, 0.01 / from_d);
  EXPECT_NEAR(relative_variance(std::nullopt, log_gain), shape + 1.0 / from_gain, 0.01 / from_gain);
  EXPECT_NEAR(relative_variance(d, log_gain), shape + 1.0 / (from_d + from_gain),
              0.01 / (from_d + from_gain));
}

TEST(PowerBound, CurvedRoad) {
  PowerVector truth = straight_truth(20.0 * kPi);
  truth[kPowerSpeed] = 40.0;
  truth[kPowerPerpendicular] = 0.0;
  std::vector<double> time_s;
  for (int i = 0; i < 100; ++i) time_s.push_back(i * 1e-3);
  PowerSetting setting;
  setting.curved = true;
  PowerKnowledge known = nothing_known();
  for (const PowerParameter p : {kPowerLogGain, kPowerPerpendicular, kPowerExponent, kPowerRadius})
    known[p] = Uncertain{truth[p], 0.0};
  const double sigma =
      std::pow(80.0 * std::sin(0.25 * kPi), -kExponent) * std::pow(10.0, -30.0 / 20.0);
  const auto bound = std::get<PowerMatrix>(power_bound(time_s, sigma, truth, known, setting));
  EXPECT_NEAR(100.0 * std::sqrt(bound(kPowerSpeed, kPowerSpeed)) / 40.0, 16.7, 0.3);
  known[kPowerLogGain].reset();
  known[kPowerRadius].reset();
  const auto refused = power_bound(time_s, sigma, truth, known, setting);
  EXPECT_EQ(std::get<PowerRefusal>(refused).reason,
            "speed is not observable: K and r_c both unknown and d = 0");
  EXPECT_THROW(power_bound(time_s, 0.0, truth, known, setting), std::domain_error);
}

}  // namespace
}  // namespace vildar
