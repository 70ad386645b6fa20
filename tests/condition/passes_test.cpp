#include <algorithm>
#include <cmath>
#include <functional>

#include "condition/condition.h"
#include "condition/noise.h"
#include "core/random.h"

namespace vildar {
namespace {

constexpr double kSigma_w = 2e-4;

struct Scene {
  double rate_hz = 1000.0;
  double duration_s = 20.0;
  std::vector<double> vehicles_s = {};  ///< when each passes, at 15 m/s, 5 m away
  double flicker_w = 0.0;               ///< of a lamp at 100 Hz
  bool low_beams = false;               ///< six times as bright until 32 m before, then a fifth
};

// Near a low photodiode the cut-off goes by: bright far off, dim, and as the law has it at last.
double low_beam(double along_m) {
  const auto after = [&](double place_m) {
    return 1.0 / (1.0 + std::exp((place_m - along_m) / 3.0));
  };
  return 6.0 - 5.8 * after(-32.0) + 0.8 * after(-12.0);
}

double light_w(const Scene& scene, double time_s) {
  double power_w = 0.02 + scene.flicker_w * std::sin(2.0 * kPi * 100.0 * time_s);
  for (const double at_s : scene.vehicles_s) {
    const double along_m = 15.0 * (time_s - at_s);
    if (along_m < 0.0)
      power_w += (scene.low_beams ? low_beam(along_m) : 1.0) / (along_m * along_m + 25.0);
  }
  return power_w;
}

PowerTrace trace_of(const Scene& scene, Random& random,
                    const std::function<bool(double)>& lost = {}) {
  PowerTrace trace;
  for (int k = 0; k < scene.duration_s * scene.rate_hz; ++k) {
    const double time_s = k / scene.rate_hz;
    if (lost && lost(time_s)) continue;
    trace.time_s.push_back(time_s);
    trace.power_w.push_back(
        static_cast<float>(light_w(scene, time_s) + random.normal(0.0, kSigma_w)));
  }
  set_noise(trace);
  set_ambient(trace);
  return trace;
}

TEST(FindPasses, DarknessHasNone) {
  Random random(1);
  for (int trial = 0; trial < 20; ++trial) {
    EXPECT_TRUE(find_passes(trace_of({.rate_hz = 1000, .duration_s = 10}, random)).empty());
    EXPECT_TRUE(find_passes(trace_of({.rate_hz = 100, .duration_s = 30}, random)).empty());
  }
  EXPECT_TRUE(find_passes(trace_of({.flicker_w = 0.01}, random)).empty())
      << "flicker of 50 sigma is no vehicle";
  EXPECT_TRUE(find_passes(PowerTrace{}).empty());
}

// What is left of a light that is cut off is the vehicle's own.
TEST(FindPasses, ALightThatTheRecordCutsOffSaysNothingOfOthers) {
  Random random(4);
  for (const double before_s : {1.0, 0.5, 0.02}) {
    const auto passes =
        find_passes(trace_of({.duration_s = 8.0 - before_s, .vehicles_s = {8.0}}, random));
    ASSERT_EQ(passes.size(), 1U) << before_s;
    EXPECT_TRUE(passes[0].cut_off);
    EXPECT_EQ(passes[0].others_w, 0.0);
  }
  const auto whole = find_passes(trace_of({.duration_s = 8.5, .vehicles_s = {8.0}}, random));
  ASSERT_EQ(whole.size(), 1U);
  EXPECT_FALSE(whole[0].cut_off);
}

TEST(FindPasses, EachVehicleIsOnePassAroundItsPeak) {
  Random random(2);
  for (const double rate_hz : {100.0, 1000.0, 10000.0}) {
    const std::vector<PowerPass> passes =
        find_passes(trace_of({.rate_hz = rate_hz, .vehicles_s = {6.0, 15.0}}, random));
    ASSERT_EQ(passes.size(), 2U) << rate_hz;
    const double block_s = std::max(0.02, 4.0 / rate_hz);
    for (const auto& [pass, at_s] : {std::pair(passes[0], 6.0), std::pair(passes[1], 15.0)}) {
      EXPECT_NEAR(pass.peak_s, at_s, 1.1 * block_s);
      EXPECT_NEAR(pass.to_s, at_s, 1.1 * block_s);
      // Half the threshold of 2 % of the peak is 1 % of 1/25 W, the power from 49.7 m away, 3.3 s
      // before; noise may end it sooner.
      EXPECT_NEAR(pass.from_s, at_s - 3.3, 0.8);
    }
  }
}

TEST(FindPasses, VehiclesInAQueueAreParted) {
  Random random(3);
  const std::vector<PowerPass> passes =
      find_passes(trace_of({.vehicles_s = {8.0, 9.5, 11.0}}, random));
  ASSERT_EQ(passes.size(), 3U);
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_NEAR(passes[k].peak_s, 8.0 + 1.5 * static_cast<double>(k), 0.03);
  EXPECT_LE(passes[0].to_s, passes[1].from_s + 1e-9);
  EXPECT_LE(passes[1].to_s, passes[2].from_s + 1e-9);
}

TEST(FindPasses, AVehicleWhoseCutOffGoesByIsOnePass) {
  Random random(9);
  for (const double rate_hz : {100.0, 1000.0}) {
    const auto alone =
        find_passes(trace_of({.rate_hz = rate_hz, .vehicles_s = {8.0}, .low_beams = true}, random));
    ASSERT_EQ(alone.size(), 1U) << rate_hz;
    EXPECT_NEAR(alone[0].peak_s, 8.0, 0.05);
    EXPECT_LT(alone[0].from_s, 6.0);
    const auto queue = find_passes(
        trace_of({.rate_hz = rate_hz, .vehicles_s = {8.0, 10.5, 13.0}, .low_beams = true}, random));
    EXPECT_EQ(queue.size(), 3U) << rate_hz;
  }
}

// The first turns off 20 m before the photodiode: its light fades as gently as by a cut-off.
TEST(FindPasses, OneThatTurnsOffIsNotThatWhichComesNext) {
  Random random(10);
  PowerTrace trace = trace_of({.vehicles_s = {12.0}}, random);
  for (std::size_t i = 0; i < trace.time_s.size(); ++i) {
    const double along_m = 15.0 * (8.0 - trace.time_s[i]);
    const double seen = 1.0 / (1.0 + std::exp((trace.time_s[i] - 6.8) / 0.15));
    trace.power_w[i] += static_cast<float>(seen / (along_m * along_m + 25.0));
  }
  set_noise(trace);
  set_ambient(trace);
  EXPECT_EQ(find_passes(trace).size(), 2U);
}

TEST(FindPasses, TheLightOfThoseBehindIsTold) {
  Random random(7);
  const std::vector<PowerPass> passes = find_passes(trace_of({.vehicles_s = {8.0, 10.0}}, random));
  ASSERT_EQ(passes.size(), 2U);
  // When the first is past, the second is 2 s or 30 m from being abreast, and comes nearer by 0.3 m
  // in a block.
  const double behind_w = 1.0 / (30.0 * 30.0 + 25.0);
  EXPECT_NEAR(passes[0].others_w, behind_w, 0.05 * behind_w + 5.0 * kSigma_w / std::sqrt(20.0));
  EXPECT_NEAR(passes[1].others_w, 0.0, 5.0 * kSigma_w / std::sqrt(20.0));
}

// It rises by an eighth when the first is past, and is gone within a second.
TEST(FindPasses, TheLightOfAFollowerThatHardlyRisesIsTold) {
  constexpr double kFollower_w = 0.012;
  Random random(7);
  PowerTrace trace = trace_of({.vehicles_s = {8.0}}, random);
  for (std::size_t i = 0; i < trace.time_s.size(); ++i)
    trace.power_w[i] +=
        static_cast<float>(kFollower_w * std::exp(-std::pow((trace.time_s[i] - 8.5) / 0.8, 4)));
  set_noise(trace);
  set_ambient(trace);
  const std::vector<PowerPass> passes = find_passes(trace);
  ASSERT_EQ(passes.size(), 1U);
  EXPECT_GT(passes[0].others_w, 0.8 * kFollower_w);
  EXPECT_LT(passes[0].others_w, 0.9 * kFollower_w);
}

TEST(FindPasses, ItsOwnLightThatFadesForTwoSecondsIsNotThatOfOthers) {
  Random random(17);
  PowerTrace trace = trace_of({}, random);
  for (std::size_t i = 0; i < trace.time_s.size(); ++i)
    trace.power_w[i] +=
        static_cast<float>(0.04 * std::exp(-std::pow((trace.time_s[i] - 8.0) / 0.9, 2)));
  const std::vector<PowerPass> passes = find_passes(trace);
  ASSERT_EQ(passes.size(), 1U);
  EXPECT_NEAR(passes[0].peak_s, 8.0, 0.1);
  EXPECT_NEAR(passes[0].others_w, 0.0, 5.0 * kSigma_w / std::sqrt(20.0));
}

TEST(FindPasses, WhereItWasNeverDarkTheLeastLightIsTheFloor) {
  Random random(8);
  PowerTrace trace = trace_of({.vehicles_s = {6.0, 15.0}}, random);
  trace.ambient_w = 0.0;  // not known, as beside a stream of traffic
  trace.ambient_sigma_w = 0.02;
  EXPECT_EQ(find_passes(trace).size(), 2U);
}

TEST(FindPasses, AGapWithinAPassDoesNotPartIt) {
  Random random(4);
  const auto lost = [](double time_s) { return time_s > 5.0 && time_s < 5.4; };
  const std::vector<PowerPass> passes = find_passes(trace_of({.vehicles_s = {6.0}}, random, lost));
  ASSERT_EQ(passes.size(), 1U);
  EXPECT_LT(passes[0].from_s, 5.0);
  EXPECT_NEAR(passes[0].to_s, 6.0, 0.03);
}

TEST(FindPasses, TimeReversedGivesTheSamePassesReversed) {
  Random random(5);
  PowerTrace trace = trace_of({.vehicles_s = {6.0, 15.0}}, random);
  const std::vector<PowerPass> forward = find_passes(trace);
  const double end_s = trace.time_s.back();
  std::reverse(trace.power_w.begin(), trace.power_w.end());
  const std::vector<PowerPass> backward = find_passes(trace);
  ASSERT_EQ(forward.size(), backward.size());
  for (std::size_t k = 0; k < forward.size(); ++k)
    EXPECT_NEAR(backward[forward.size() - 1 - k].peak_s, end_s - forward[k].peak_s, 0.021);
}

TEST(FindPasses, DoNotOverlapWhereStampsAreUneven) {
  Random random(6);
  for (int trial = 0; trial < 50; ++trial) {
    PowerTrace trace = trace_of({.rate_hz = 100.0, .vehicles_s = {6.0, 6.8}}, random);
    for (double& time_s : trace.time_s) time_s += random.uniform(-0.0045, 0.0045);
    set_noise(trace);
    set_ambient(trace);
    const std::vector<PowerPass> passes = find_passes(trace);
    ASSERT_EQ(passes.size(), 2U) << trial;
    EXPECT_LE(passes[0].from_s, passes[0].to_s);
    EXPECT_LE(passes[0].to_s, passes[1].from_s) << trial;
  }
}

}  // namespace
}  // namespace vildar
