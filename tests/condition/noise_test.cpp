#include "condition/noise.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "condition/condition.h"
#include "core/random.h"

namespace vildar {
namespace {

/// A vehicle at constant speed on top of a level, gamma = 2, nearest at 5 m; power 1 at 1 m.
double passing_w(double time_s, double at_s) {
  const double along_m = 15.0 * (time_s - at_s);
  return time_s > at_s ? 0.0 : 1.0 / (along_m * along_m + 25.0);
}

PowerTrace trace_of(double rate_hz, double duration_s,
                    const std::function<double(double)>& power_w) {
  PowerTrace trace;
  for (int k = 0; k < duration_s * rate_hz; ++k) {
    trace.time_s.push_back(k / rate_hz);
    trace.power_w.push_back(static_cast<float>(power_w(k / rate_hz)));
  }
  set_noise(trace);
  set_ambient(trace);
  return trace;
}

TEST(Noise, MedianAndQuantilesMatchSorting) {
  Random random(1);
  for (std::size_t n = 1; n < 40; ++n) {
    std::vector<double> values(n);
    for (double& value : values) value = random.normal();
    std::vector<double> sorted = values;
    std::sort(sorted.begin(), sorted.end());
    EXPECT_EQ(median_of(values),
              n % 2 != 0 ? sorted[n / 2] : 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]));
    EXPECT_EQ(quantile_of(values, 0.0), sorted.front());
    EXPECT_EQ(quantile_of(values, 1.0), sorted.back());
  }
}

TEST(Noise, SigmaIsThatOfTheWhiteNoiseWhateverPasses) {
  constexpr double kSigma_w = 2e-3;
  // The median of |step| over n samples scatters by about 1.2 / sqrt(n) of itself (steps
  // correlated); 5 sigma.
  constexpr double kRelative = 5.0 * 1.2 / 141.0;
  Random random(2);
  for (const double vehicle : {0.0, 1.0}) {
    const PowerTrace trace = trace_of(1000, 20, [&](double t) {
      return 0.3 + 0.01 * t + vehicle * passing_w(t, 8.0) + random.normal(0.0, kSigma_w);
    });
    EXPECT_NEAR(trace.noise_sigma_w / kSigma_w, 1.0, kRelative);
    EXPECT_NEAR(trace.sample_period_s, 1e-3, 1e-12);
  }
}

TEST(Noise, RoundingIsNoiseWhereTheConverterHidesTheRest) {
  int k = 0;
  const PowerTrace trace = trace_of(1000, 5, [&](double) { return k++ % 100 < 70 ? 0.25 : 0.5; });
  EXPECT_NEAR(trace.noise_sigma_w, 0.25 / std::sqrt(12.0), 1e-6);
}

TEST(Noise, AmbientIsTheDarkLevelUnderNoiseFlickerAndVehicles) {
  constexpr double kAmbient_w = 0.05, kSigma_w = 1e-3;
  Random random(3);
  for (const double flicker_hz : {100.0, 120.0}) {
    const PowerTrace trace = trace_of(2000, 30, [&](double t) {
      return kAmbient_w * (1.0 + 0.3 * std::sin(2.0 * kPi * flicker_hz * t)) + passing_w(t, 7.0) +
             passing_w(t, 19.0) + random.normal(0.0, kSigma_w);
    });
    // Means of 100 samples scatter by 1e-4; the far light of a vehicle at 100 m is as much.
    EXPECT_NEAR(trace.ambient_w, kAmbient_w, 2e-4);
  }
  const PowerTrace dark = trace_of(100, 60, [&](double) { return random.normal(0.0, kSigma_w); });
  EXPECT_NEAR(dark.ambient_w, 0.0, 1e-4)
      << "1200 means of 5 samples, their median to 1.6e-5, less a slight cut of the top";
}

TEST(Noise, AmbientSaysHowSureItIs) {
  constexpr double kAmbient_w = 0.05, kSigma_w = 1e-3;
  Random random(4);
  const PowerTrace quiet = trace_of(1000, 30, [&](double t) {
    return kAmbient_w + passing_w(t, 7.0) + random.normal(0.0, kSigma_w);
  });
  EXPECT_LT(quiet.ambient_sigma_w, 1e-4) << "23 s without a vehicle";
  // From the first sample to the last a vehicle comes nearer: its light stands in every sample.
  const PowerTrace never_dark = trace_of(1000, 3, [&](double t) {
    return kAmbient_w + 50.0 * passing_w(t, 3.2) + random.normal(0.0, kSigma_w);
  });
  EXPECT_GT(never_dark.ambient_sigma_w, 0.01);
  EXPECT_LT(std::abs(never_dark.ambient_w - kAmbient_w), 2.0 * never_dark.ambient_sigma_w);
}

TEST(Noise, TheFloorRightAfterAVehicleIsTheAmbient) {
  constexpr double kAmbient_w = 0.05, kSigma_w = 1e-4;
  Random random(6);
  const auto vehicle_until = [&](double gone_s, double to_s) {
    return trace_of(1000, to_s, [&](double t) {
      return kAmbient_w + 50.0 * passing_w(t, gone_s) + random.normal(0.0, kSigma_w);
    });
  };
  const PowerTrace told = vehicle_until(7.5, 8.0);
  EXPECT_NEAR(told.ambient_w, kAmbient_w, 2.0 * told.ambient_sigma_w);
  EXPECT_LT(told.ambient_sigma_w, 1e-3) << "half a second in eight is dark";
  EXPECT_GT(vehicle_until(7.9, 8.0).ambient_sigma_w, 0.01) << "too short to tell it from light";
  const PowerTrace far_first = trace_of(1000, 3, [&](double t) {
    return kAmbient_w + 50.0 * passing_w(t, 8.0) + random.normal(0.0, kSigma_w);
  });
  EXPECT_GT(far_first.ambient_sigma_w, 0.01) << "the lowest light is that of a far vehicle";
}

TEST(Noise, LightOfAFollowerIsNotToldAsAmbient) {
  constexpr double kAmbient_w = 0.05;
  Random random(8);
  for (const double sigma_w : {2e-5, 1e-4, 5e-4})
    for (const double brighter : {0.5, 1.0, 4.0})
      for (double behind_s = 8.0; behind_s <= 30.0; behind_s += 1.0) {
        const PowerTrace trace = trace_of(1000, 8, [&](double t) {
          return kAmbient_w + 50.0 * passing_w(t, 7.5) +
                 brighter * 50.0 * passing_w(t, 7.5 + behind_s) + random.normal(0.0, sigma_w);
        });
        EXPECT_LT(std::abs(trace.ambient_w - kAmbient_w), 3.0 * trace.ambient_sigma_w)
            << brighter << " times as bright, " << behind_s << " s behind, noise " << sigma_w;
      }
}

// Behind a bend they are hidden at first; what follows them shines throughout.
TEST(Noise, AFloorBeforeVehiclesThatAreLetInIsTheAmbient) {
  constexpr double kAmbient_w = 0.05, kSigma_w = 1e-4;
  Random random(10);
  for (const double headway_s : {5.0, 7.0, 9.0})
    for (const double hidden_s : {0.0, 0.5, 1.5}) {
      const PowerTrace trace = trace_of(1000, 6.0 * headway_s, [&](double t) {
        double power_w = kAmbient_w + random.normal(0.0, kSigma_w);
        for (int i = 1; i <= 8 && t > hidden_s; ++i) power_w += 50.0 * passing_w(t, i * headway_s);
        return power_w;
      });
      EXPECT_LT(std::abs(trace.ambient_w - kAmbient_w), 3.0 * trace.ambient_sigma_w)
          << headway_s << " s apart, hidden for " << hidden_s << " s";
      if (hidden_s > 1.0) {
        EXPECT_LT(trace.ambient_sigma_w, 1e-3);
      }
    }
}

// Where the light of a vehicle that comes nearer throughout is hardly told from a level at first.
TEST(Noise, LightThatGrowsUnderNoiseIsNotToldAsAmbient) {
  constexpr double kAmbient_w = 0.05;
  Random random(9);
  int read = 0;
  for (const double duration_s : {0.3, 0.75, 2.5})
    for (const double past_s : {0.2, 1.0, 3.0})
      for (const double signal_db : {5.0, 10.0, 20.0, 40.0})
        for (int trial = 0; trial < 10; ++trial) {
          const double first_w = passing_w(0.0, duration_s + past_s);
          const double sigma_w = first_w * std::pow(10.0, -signal_db / 20.0);
          const PowerTrace trace = trace_of(1000, duration_s, [&](double t) {
            return kAmbient_w + passing_w(t, duration_s + past_s) + random.normal(0.0, sigma_w);
          });
          if (find_passes(trace).empty()) continue;
          ++read;
          EXPECT_LT(std::abs(trace.ambient_w - kAmbient_w), 3.0 * trace.ambient_sigma_w)
              << duration_s << " s, " << past_s << " s before it is past, " << signal_db << " dB";
        }
  EXPECT_GT(read, 100);
}

TEST(Noise, WithoutNoiseAThirdOfASecondTellsTheAmbient) {
  constexpr double kAmbient_w = 0.05;
  const auto vehicles = [](double follower) {
    return trace_of(1000, 7.95, [follower](double t) {
      return kAmbient_w + 50.0 * passing_w(t, 7.5) + follower * passing_w(t, 17.5);
    });
  };
  const PowerTrace alone = vehicles(0.0);
  EXPECT_NEAR(alone.ambient_w, kAmbient_w, 1e-8);
  EXPECT_LT(alone.ambient_sigma_w, 5e-3 * kAmbient_w);
  EXPECT_GT(vehicles(50.0).ambient_sigma_w, 0.01) << "a follower's light grows";
}

TEST(Noise, RoundingThatNoiseDoesNotEvenOutStaysInMeans) {
  constexpr int kLevels = 400, kSamples = 2000;
  // A level in the middle of a code shows no noise: what is told then is that of none.
  constexpr double kLeast = 0.9, kMostBeyond_w = 0.06;
  Random random(7);
  for (const double noise_steps : {0.0, 0.1, 0.2, 0.3}) {
    double square = 0.0, ambient_square = 0.0, told_w = 0.0, ambient_told_w = 0.0;
    for (int level = 0; level < kLevels; ++level) {
      const double true_w = 10.0 + (level + 0.5) / kLevels;
      double sum_w = 0.0;
      // A level one step up for a moment shows the step where the first is all of one code.
      const PowerTrace trace = trace_of(1000, kSamples / 1000.0, [&](double t) {
        const double code =
            std::round(true_w + (t < 0.01 ? 1.0 : 0.0) + random.normal(0.0, noise_steps));
        sum_w += t < 0.01 ? 0.0 : code;
        return code;
      });
      square += std::pow(sum_w / (kSamples - 10) - true_w, 2) / kLevels;
      ambient_square += std::pow(trace.ambient_w - true_w, 2) / kLevels;
      told_w += trace.rounding_sigma_w / kLevels;
      ambient_told_w += trace.ambient_sigma_w / kLevels;
    }
    for (const auto& [sigma_w, true_square] :
         {std::pair(told_w, square), std::pair(ambient_told_w, ambient_square)}) {
      EXPECT_GT(sigma_w, kLeast * std::sqrt(true_square)) << noise_steps;
      EXPECT_LT(sigma_w, kMostBeyond_w + std::sqrt(true_square)) << noise_steps;
    }
  }
}

TEST(Noise, LightThatRisesOrFallsIsNoNoise) {
  constexpr double kDark_w = 10.3, kPerSample_w = 1.7;
  for (const auto& [rises_s, falls_s] : {std::pair(4.0, 0.0), {9.0, 0.0}, {4.0, 4.0}}) {
    const PowerTrace trace = trace_of(1000, 20.0, [&](double t) {
      const double lit_s = std::max({0.0, t - (20.0 - rises_s), falls_s - t});
      return std::round(kDark_w + kPerSample_w * 1000.0 * lit_s);
    });
    EXPECT_NEAR(trace.rounding_sigma_w, 1.0 / std::sqrt(12.0), 0.01) << rises_s << " " << falls_s;
  }
}

TEST(Noise, AFewSamplesAreNoFault) {
  for (const double duration_s : {0.0, 0.001, 0.002, 0.003}) {
    const PowerTrace trace = trace_of(1000, duration_s, [](double) { return 0.5; });
    EXPECT_EQ(trace.noise_sigma_w, 0.0);
    EXPECT_EQ(trace.ambient_w, trace.time_s.empty() ? 0.0 : 0.5);
  }
}

}  // namespace
}  // namespace vildar
