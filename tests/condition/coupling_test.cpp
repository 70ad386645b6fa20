#include "condition/coupling.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "condition/noise.h"
#include "core/random.h"

namespace vildar {
namespace {

constexpr double kRate_hz = 1000.0, kDark_w = 5e-9, kNoise_w = 1e-10;

struct Passing {
  double at_s, speed_mps;
  double lamps = 1.0;  ///< of the others' light
};

/// Vehicles that are gone within 0.3 s of their nearest, over a dark level with noise.
std::vector<double> light_of(const std::vector<Passing>& vehicles, double duration_s) {
  std::vector<double> light_w;
  for (int k = 0; k < static_cast<int>(duration_s * kRate_hz); ++k) {
    light_w.push_back(kDark_w);
    for (const Passing& one : vehicles) {
      const double ahead_m = one.speed_mps * (one.at_s - k / kRate_hz);
      const double fades = ahead_m > 0.0 ? 1.0 : std::exp(ahead_m);
      light_w.back() += fades * 1e-4 / (ahead_m * ahead_m + 25.0);
    }
  }
  return light_w;
}

PowerTrace trace_of(const std::vector<double>& light_w) {
  Random random(7);
  PowerTrace trace;
  for (std::size_t k = 0; k < light_w.size(); ++k) {
    trace.time_s.push_back(static_cast<double>(k) / kRate_hz);
    trace.power_w.push_back(static_cast<float>(light_w[k] + random.normal(0.0, kNoise_w)));
  }
  set_noise(trace);
  return trace;
}

/// A high pass of first order, as a capacitor is one.
std::vector<double> through_capacitor(const std::vector<double>& light_w, double corner_hz) {
  const double keeps = std::exp(-2.0 * M_PI * corner_hz / kRate_hz);
  std::vector<double> passed{0.0};
  for (std::size_t k = 1; k < light_w.size(); ++k)
    passed.push_back(keeps * passed.back() + light_w[k] - light_w[k - 1]);
  return passed;
}

TEST(BlocksConstantLight, IsToldByTheSwingAfterAVehicle) {
  for (const double corner_hz : {0.02, 0.05, 0.2, 1.0, 5.0, 20.0})
    for (const auto& vehicles :
         {std::vector<Passing>{{10.0, 20.0}}, {{10.0, 8.0}, {25.0, 30.0}, {40.0, 15.0}}}) {
      const auto light_w = light_of(vehicles, 50.0);
      EXPECT_TRUE(blocks_constant_light(trace_of(through_capacitor(light_w, corner_hz))))
          << corner_hz << " Hz, " << vehicles.size();
    }
}

TEST(BlocksConstantLight, LightItselfDoesNotSwing) {
  for (const auto& vehicles : {std::vector<Passing>{},
                               {{10.0, 20.0}},
                               {{10.0, 8.0}, {25.0, 30.0}, {40.0, 15.0}},
                               {{10.0, 15.0}, {12.5, 15.0}, {15.0, 15.0}, {17.5, 15.0}},
                               {{10.0, 25.0}, {11.0, 25.0}, {14.0, 3.0}, {30.0, 20.0}}})
    for (const double lasts_s : {50.0, 16.0})
      EXPECT_FALSE(blocks_constant_light(trace_of(light_of(vehicles, lasts_s))))
          << vehicles.size() << ", " << lasts_s << " s";
}

TEST(BlocksConstantLight, AmbientThatFallsAndRisesIsNoSwing) {
  for (const double period_s : {3.0, 20.0, 60.0}) {
    auto light_w = light_of({{10.0, 20.0}, {25.0, 20.0}, {40.0, 20.0}}, 50.0);
    for (std::size_t k = 0; k < light_w.size(); ++k)
      light_w[k] +=
          3e-7 * (1.0 + std::sin(2.0 * M_PI * static_cast<double>(k) / kRate_hz / period_s));
    EXPECT_FALSE(blocks_constant_light(trace_of(light_w))) << period_s;
  }
}

// Light of the next one, which falls off with a power of 1.21 alone, rises almost straight.
TEST(BlocksConstantLight, NeitherDoStreamsOfVehiclesInNoise) {
  for (const double speed_mps : {5.0, 8.0, 12.0})
    for (const double every_s : {6.0, 10.0, 12.0})
      for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        Random random(seed);
        PowerTrace trace;
        for (int k = 0; k < 60'000; ++k) {
          const double time_s = k / kRate_hz;
          double light_w = 0.0;
          for (double at_s = 5.0; at_s < 90.0; at_s += every_s) {
            const double ahead_m = speed_mps * (at_s - time_s);
            if (ahead_m > 0.0) light_w += std::pow(ahead_m * ahead_m + 25.0, -0.605);
          }
          trace.time_s.push_back(time_s);
          trace.power_w.push_back(static_cast<float>(light_w + random.normal(0.0, 1.4e-3)));
        }
        set_noise(trace);
        EXPECT_FALSE(blocks_constant_light(trace))
            << speed_mps << " m/s, " << every_s << " s, " << seed;
      }
}

/// Light that is gone at once as each leaves the field of view, over a dark level with noise.
std::vector<double> light_in_view(const std::vector<Passing>& vehicles, double gone_m,
                                  double duration_s) {
  std::vector<double> light_w;
  for (int k = 0; k < static_cast<int>(duration_s * kRate_hz); ++k) {
    light_w.push_back(kDark_w);
    for (const Passing& one : vehicles) {
      const double ahead_m = one.speed_mps * (one.at_s - k / kRate_hz);
      const double in_view = 1.0 / (1.0 + std::exp(4.0 * (gone_m - ahead_m)));
      light_w.back() += in_view * one.lamps * 2e-6 * std::pow(ahead_m * ahead_m + 50.0, -0.605);
    }
  }
  return light_w;
}

TEST(BlocksConstantLight, IsToldByTheSwingAlsoOfLightThatRisesSlowly) {
  for (const double corner_hz : {0.02, 0.05, 0.2, 1.0, 5.0, 20.0})
    for (const double speed_mps : {8.0, 15.0, 30.0})
      for (const double lamps : {0.3, 1.0, 3.0}) {
        const auto light_w = light_in_view(
            {{12.0, speed_mps}, {27.0, 15.0, lamps}, {42.0, speed_mps, lamps}}, 2.0, 50.0);
        EXPECT_TRUE(blocks_constant_light(trace_of(through_capacitor(light_w, corner_hz))))
            << corner_hz << " Hz, " << speed_mps << " m/s, lamps of " << lamps;
      }
}

// Nothing before the first vehicle is as dark as the gap after it, or as what comes at last.
TEST(BlocksConstantLight, NorDoesWhatBeginsWithVehiclesInView) {
  for (const double from_m : {25.0, 35.0, 45.0, 60.0})
    for (const double gap_s : {1.8, 2.1, 2.4, 3.0, 4.0})
      for (const double gone_m : {1.0, 3.0, 6.0})
        for (const double lamps : {0.1, 0.15, 0.2, 0.3, 0.5, 1.0})
          for (const double dark_s : {1.6, 5.0}) {
            const double first_s = from_m / 17.0, next_s = first_s + gap_s;
            const auto light_w =
                light_in_view({{first_s, 17.0}, {next_s, 15.0, lamps}}, gone_m, next_s + dark_s);
            EXPECT_FALSE(blocks_constant_light(trace_of(light_w)))
                << from_m << " m, " << gap_s << " s, gone at " << gone_m << " m, lamps of " << lamps
                << ", dark for " << dark_s << " s";
          }
}

// One that stands in view at first, and drives off.
TEST(BlocksConstantLight, NorDoesWhatBeginsWithAVehicleThatStands) {
  for (const double gap_s : {1.8, 2.1, 2.4, 3.0, 4.0})
    for (const double lamps : {0.1, 0.15, 0.2, 0.3, 0.5, 1.0})
      for (const double dark_s : {1.6, 5.0}) {
        auto light_w =
            light_in_view({{5.0, 10.0}, {5.0 + gap_s, 15.0, lamps}}, 2.0, 5.0 + gap_s + dark_s);
        std::fill_n(light_w.begin(), 3000, light_w[3000]);
        EXPECT_FALSE(blocks_constant_light(trace_of(light_w)))
            << gap_s << ", lamps of " << lamps << ", " << dark_s;
      }
}

// Tail lamps of one that drives away on the other side: they come into view beside the photodiode
// as the vehicle goes by, and fade.
TEST(BlocksConstantLight, NorDoTailLampsThatComeAndFade) {
  for (const double begins_s : {0.1, 0.3, 0.6})
    for (const double lamps : {0.05, 0.1, 0.2}) {
      auto light_w = light_in_view({{8.0, 10.0}}, 1.0, 14.0);
      for (std::size_t k = 0; k < light_w.size(); ++k) {
        const double since_s = static_cast<double>(k) / kRate_hz - 8.0 - begins_s;
        const double away_m = 12.0 * std::max(0.0, since_s);
        light_w[k] += lamps * 4e-6 * (1.0 - std::exp(-std::max(0.0, since_s) / 0.15)) /
                      (1.0 + away_m * away_m / 100.0);
      }
      EXPECT_FALSE(blocks_constant_light(trace_of(light_w))) << begins_s << " s, " << lamps;
    }
}

TEST(BlocksConstantLight, NorDoesASpikeBelowDark) {
  auto light_w = light_of({{10.0, 20.0}}, 20.0);
  for (std::size_t k = 10'500; k < 10'503; ++k) light_w[k] -= 1e-6;
  EXPECT_FALSE(blocks_constant_light(trace_of(light_w)));
}

TEST(BlocksConstantLight, ATraceOfNothingTellsNothing) {
  EXPECT_FALSE(blocks_constant_light({}));
  EXPECT_FALSE(blocks_constant_light(trace_of({1e-9, 2e-9, 3e-9})));
}

}  // namespace
}  // namespace vildar
