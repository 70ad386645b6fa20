#include "estimate/power_slope.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

#include "core/random.h"

namespace vildar {
namespace {

// The paper's pass: V = 20 m/s, R_o = 15 m, d = 0.5 m, sampled at 1 kHz.
constexpr double kSpeed_mps = 20.0;
constexpr double kStart_m = 15.0;
constexpr double kPerpendicular_m = 0.5;
constexpr PowerLaw kSimulated{1.0, 1.21, 0.0};

struct SlopeSamples {
  std::vector<double> time_s, power_w;
};

SlopeSamples first_window(double length_s, double sigma_w, Random& random) {
  SlopeSamples samples;
  const auto count = static_cast<int>(std::lround(length_s * 1000.0));
  for (int i = 0; i < count; ++i) {
    const double t_s = i * 1e-3;
    samples.time_s.push_back(t_s);
    samples.power_w.push_back(
        std::pow(std::hypot(kPerpendicular_m, kStart_m - kSpeed_mps * t_s), -1.21) +
        sigma_w * random.normal());
  }
  return samples;
}

PowerSlopeFit fitted(const SlopeSamples& samples) {
  return std::get<PowerSlopeFit>(
      fit_power_slope(samples.time_s, samples.power_w, kSimulated, Metres(kPerpendicular_m)));
}

TEST(PowerSlope, IsExactWithoutNoise) {
  Random random(1);
  const PowerSlopeFit fit = fitted(first_window(0.3, 0.0, random));
  EXPECT_NEAR(fit.speed_mps, kSpeed_mps, 1e-9);
  EXPECT_NEAR(fit.range_at_zero_m, kStart_m, 1e-9);
  EXPECT_EQ(fit.samples_used, 300);
  EXPECT_EQ(fit.samples_outside, 0);
}

TEST(PowerSlope, LeavesOutSamplesOfNoUseWhereverTheyAre) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Random random(5);
  for (int length = 40; length < 60; ++length) {
    SlopeSamples samples = first_window(length * 1e-3, 0.0, random);
    int useless = 0;
    for (std::size_t i = 0; i < samples.time_s.size(); ++i) {
      if (random.uniform() > 0.4) continue;
      ++useless;
      switch (useless % 6) {
        case 0: samples.power_w[i] = kNaN; break;
        case 1: samples.power_w[i] = kInfinity; break;
        case 2: samples.power_w[i] = -1.0; break;
        case 3: samples.power_w[i] = 1e-320; break;   // farther than any number
        case 4: samples.power_w[i] = 1e3; break;      // nearer than d
        default: samples.time_s[i] = kNaN;
      }
    }
    const PowerSlopeFit fit = fitted(samples);
    EXPECT_NEAR(fit.speed_mps, kSpeed_mps, 1e-8) << length;
    EXPECT_EQ(fit.samples_used, length - useless);
    EXPECT_EQ(fit.samples_outside, useless);
  }
}

TEST(PowerSlope, ScaleOfSpeedFollowsTheGain) {
  // d = 0: P -> c P reads every distance c^(-1/gamma) times as long.
  SlopeSamples samples;
  for (int i = 0; i < 100; ++i) {
    samples.time_s.push_back(i * 1e-3);
    samples.power_w.push_back(3.0 * std::pow(15.0 - 20.0 * i * 1e-3, -1.21));
  }
  const auto fit = std::get<PowerSlopeFit>(
      fit_power_slope(samples.time_s, samples.power_w, kSimulated, Metres(0.0)));
  EXPECT_NEAR(fit.speed_mps / (20.0 * std::pow(3.0, -1.0 / 1.21)), 1.0, 1e-12);
}

// First window of the paper's pass, R 15 -> 9 m, SNR = 20 log10(P0 / sigma).
TEST(PowerSlope, FirstWindowScatterIsTheKnownOne) {
  constexpr int kTrials = 2000;  // one sigma of a standard deviation: 1.6 %
  constexpr double kRelative = 0.10;
  const double power_at_start_w = std::pow(std::hypot(kPerpendicular_m, kStart_m), -1.21);
  Random random(20260101);
  for (const auto& [snr_db, percent] :
       {std::pair{20.0, 2.89}, {30.0, 0.88}, {40.0, 0.28}, {50.0, 0.088}}) {
    const double sigma_w = power_at_start_w * std::pow(10.0, -snr_db / 20.0);
    double sum = 0.0, sum2 = 0.0;
    for (int trial = 0; trial < kTrials; ++trial) {
      const double v = fitted(first_window(0.3, sigma_w, random)).speed_mps;
      sum += v;
      sum2 += v * v;
    }
    const double mean = sum / kTrials;
    const double std_percent = 100.0 * std::sqrt(sum2 / kTrials - mean * mean) / kSpeed_mps;
    EXPECT_NEAR(std_percent / percent, 1.0, kRelative) << snr_db << " dB";
  }
}

TEST(PowerSlope, SigmaCoversTheTruthTwoTimesInThree) {
  constexpr int kTrials = 1000;
  constexpr double kSlack = 0.06;  // four binomial sigmas
  Random random(7);
  const double sigma_w = 1e-2 * std::pow(kStart_m, -1.21);
  int covered = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const PowerSlopeFit fit = fitted(first_window(0.1, sigma_w, random));
    covered += std::abs(fit.speed_mps - kSpeed_mps) < fit.speed_sigma_mps;
  }
  EXPECT_NEAR(covered / static_cast<double>(kTrials), 0.683, kSlack);
}

TEST(PowerSlope, SamplesOutsideTheModelAreLeftOutAndCounted) {
  Random random(1);
  SlopeSamples samples = first_window(0.3, 0.0, random);
  const double nearer_than_d_w = std::pow(0.4 * kPerpendicular_m, -1.21);
  samples.power_w[10] = -1.0;
  samples.power_w[20] = 0.0;
  samples.power_w[30] = std::numeric_limits<double>::quiet_NaN();
  samples.power_w[40] = nearer_than_d_w;
  samples.time_s[50] = std::numeric_limits<double>::infinity();
  const PowerSlopeFit fit = fitted(samples);
  EXPECT_EQ(fit.samples_outside, 5);
  EXPECT_EQ(fit.samples_used, 295);
  EXPECT_NEAR(fit.speed_mps, kSpeed_mps, 1e-9);
}

TEST(PowerSlope, NamesWhatIsMissing) {
  const Metres d(kPerpendicular_m);
  const auto miss = [&](std::vector<double> t_s, std::vector<double> p_w) {
    const auto outcome = fit_power_slope(t_s, p_w, kSimulated, d);
    return std::get<Miss>(outcome);
  };
  EXPECT_EQ(miss({}, {}), Miss::too_few_samples);
  EXPECT_EQ(miss({0.0}, {0.1}), Miss::too_few_samples);
  EXPECT_EQ(miss({1.0, 1.0, 1.0}, {0.1, 0.1, 0.1}), Miss::no_time_spread);
  EXPECT_EQ(miss({0.0, 0.1, 0.2}, {-1.0, 0.0, -2.0}), Miss::below_noise);
  EXPECT_EQ(miss({0.0, 0.1, 0.2}, {99.0, 99.0, 99.0}), Miss::outside_model);
  EXPECT_THROW(miss({0.0, 0.1}, {0.1}), std::invalid_argument);
  const std::vector<double> t_s{0.0, 0.1, 0.2}, p_w{0.1, 0.1, 0.1};
  EXPECT_THROW(fit_power_slope(t_s, p_w, PowerLaw{0.0, 1.21, 0.0}, d), std::domain_error);
  EXPECT_THROW(fit_power_slope(t_s, p_w, kSimulated, Metres(-1.0)), std::domain_error);
}

}  // namespace
}  // namespace vildar
