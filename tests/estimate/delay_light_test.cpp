#include <gtest/gtest.h>

#include "delay_pair.h"
#include "estimate/vehicle.h"

namespace vildar {
namespace {

using simulated::Pair;
using simulated::pair_of;
using simulated::Receiving;

constexpr double kAside2_m2 = 27.0;

/// A vehicle that comes from `ahead_m` at constant speed; `light_w` of how far it still has to go.
template <class Light>
Pair coming(double speed_mps, double ahead_m, double noise_w, double period_s, Light light_w,
            Random& random) {
  Pair pair;
  for (PowerTrace* trace : {&pair.near, &pair.far}) {
    const bool far = trace == &pair.far;
    trace->photodiode = far ? 1 : 0;
    trace->sample_period_s = period_s;
    trace->noise_sigma_w = noise_w;
    trace->ambient_sigma_w = 0.1 * noise_w;
    for (double t_s = 0.0; t_s < ahead_m / speed_mps; t_s += period_s) {
      const double to_go_m = ahead_m - (far ? 2.0 : 0.0) - speed_mps * t_s;
      trace->time_s.push_back(t_s);
      trace->power_w.push_back(static_cast<float>(light_w(to_go_m) + noise_w * random.normal()));
    }
  }
  return pair;
}

// Light that grows until the lamps vanish from the photodiode's view at full light.
Pair vanishing(double speed_mps, double ahead_m, double edge_m, double noise_w, Random& random) {
  constexpr double kPeriod_s = 1e-3;
  const auto light_w = [edge_m](double to_go_m) {
    return to_go_m > edge_m ? 100.0 / (to_go_m * to_go_m + kAside2_m2) : 0.0;
  };
  return coming(speed_mps, ahead_m, noise_w, kPeriod_s, light_w, random);
}

TEST(DelayLight, AnEdgeIsNoNoise) {
  constexpr double kScatter = 0.15;  // of a variance from some hundred samples, over two
  constexpr double kNoise_w = 1e-3, kBlock_samples = 10.0;
  const Site site = simulated::two_photodiodes(2.0);
  Random random(5);
  const Pair pair = vanishing(20.0, 32.0, 2.0, kNoise_w, random);
  const auto problem = delay_problem(site, pair.near, pair.far, 0.0, 1.6, false);
  ASSERT_TRUE(std::holds_alternative<DelayProblem>(problem));
  for (const PowerBlock& block : std::get<DelayProblem>(problem).near.blocks)
    EXPECT_NEAR(block.sigma_w * std::sqrt(kBlock_samples) / kNoise_w, 1.0, kScatter);
}

// Of pulses that are evened out samples lie on lines between the means of each period, whose noise
// is that of as many samples: hardly any from one sample to the next.
TEST(DelayLight, LinesBetweenTheLevelsOfPulsesHaveTheNoiseOfTheirMeans) {
  constexpr double kNoise_w = 1e-3, kBlock_samples = 10.0;
  // In a block of ten lines weigh three means of five samples by about 0.2, 0.6 and 0.2.
  constexpr double kOfWhite = 0.9, kScatter = 0.2;
  constexpr std::size_t kPeriod = 5;
  const Site site = simulated::two_photodiodes(2.0);
  Random random(8);
  Pair pair = vanishing(20.0, 60.0, 2.0, 0.0, random);
  for (PowerTrace* trace : {&pair.near, &pair.far}) {
    trace->noise_sigma_w = kNoise_w;
    trace->ambient_sigma_w = 0.1 * kNoise_w;
    trace->pulsing = {{0.0, 3.0, 200.0, 0.6, 0.0}};
    double before_w = 0.0, after_w = 0.0;
    for (std::size_t i = 0; i < trace->power_w.size(); ++i) {
      if (i % kPeriod == 0) {
        before_w = after_w;
        after_w = kNoise_w / std::sqrt(kPeriod) * random.normal();
      }
      const double part = static_cast<double>(i % kPeriod) / static_cast<double>(kPeriod);
      trace->power_w[i] += static_cast<float>(std::lerp(before_w, after_w, part));
    }
  }
  const auto problem = delay_problem(site, pair.near, pair.far, 0.0, 3.0, false);
  ASSERT_TRUE(std::holds_alternative<DelayProblem>(problem));
  for (const PowerBlock& block : std::get<DelayProblem>(problem).near.blocks)
    EXPECT_NEAR(block.sigma_w * std::sqrt(kBlock_samples) / kNoise_w, kOfWhite, kScatter);
}

// One goes blind 16 m before the vehicle is past: the other's peak beside its faint beginning is no
// pair.
TEST(DelayLight, APhotodiodeThatGoesBlindTellsNoDelay) {
  const Site site = simulated::two_photodiodes(2.0);
  Random random(6);
  Pair pair = vanishing(20.0, 60.0, 2.0, 1e-3, random);
  for (std::size_t i = 0; i < pair.near.time_s.size(); ++i)
    if (pair.near.time_s[i] > 2.2) pair.near.power_w[i] = 0.0F;
  const auto blind = delay_problem(site, pair.near, pair.far, 0.0, 3.0, false);
  ASSERT_TRUE(std::holds_alternative<Miss>(blind));
  EXPECT_EQ(std::get<Miss>(blind), Miss::bad_fit);
}

// Wherever in a block it falls: a curve that bends to each side's means about the edge would tell
// their delay to microseconds, and be wrong by milliseconds.
TEST(DelayLight, AnEdgeTellsNoDelay) {
  constexpr int kTrials = 60;
  constexpr double kNoise_w = 3e-3;
  const Site site = simulated::two_photodiodes(2.0);
  Random random(11);
  for (int trial = 0; trial < kTrials; ++trial) {
    const double speed_mps = random.uniform(8.0, 35.0), edge_m = random.uniform(2.0, 5.0);
    const Pair pair = vanishing(speed_mps, 50.0, edge_m, kNoise_w, random);
    const auto outcome = pair.speed(site);
    ASSERT_TRUE(std::holds_alternative<DelayFit>(outcome)) << trial;
    const auto& speed = std::get<DelayFit>(outcome).speed;
    EXPECT_LT(std::abs(speed.speed_mps - speed_mps), 4.0 * speed.std_mps) << trial;
  }
}

/// Light of lamps that a view fades out to nothing at 65 degrees off the road, over the last
/// `fade_deg`.
auto fading_w(double fade_deg) {
  return [fade_deg](double to_go_m) {
    constexpr double kRim_deg = 65.0;
    if (to_go_m <= 0.0) return 0.0;
    const double aside_deg = degrees_from_radians(std::atan2(std::sqrt(kAside2_m2), to_go_m));
    const double u = std::clamp((kRim_deg - aside_deg) / fade_deg, 0.0, 1.0);
    return u * u * (3.0 - 2.0 * u) * 100.0 / (to_go_m * to_go_m + kAside2_m2);
  };
}

// Nor do a view that fades out over so many degrees before its rim, and blocks that hold a metre of
// road, as at 100 Hz: the light bends faster than the curve, which is no change of speed.
TEST(DelayLight, SharpBendsOfTheLightAreNoMotion) {
  constexpr int kTrials = 24;
  constexpr double kNoise_w = 5e-4;
  const Site site = simulated::two_photodiodes(2.0);
  Random random(12);
  for (const double fade_deg : {15.0, 25.0, 35.0})
    for (const double period_s : {1e-2, 5e-3, 1e-3}) {
      int inside = 0;
      for (int trial = 0; trial < kTrials; ++trial) {
        const double speed_mps = random.uniform(8.0, 35.0);
        const double noise_w = kNoise_w * std::sqrt(1e-3 / period_s);
        const Pair pair = coming(speed_mps, 60.0, noise_w, period_s, fading_w(fade_deg), random);
        const auto outcome = pair.speed(site);
        ASSERT_TRUE(std::holds_alternative<DelayFit>(outcome)) << fade_deg << ", " << period_s;
        const SpeedEstimate& speed = std::get<DelayFit>(outcome).speed;
        inside += std::abs(speed.speed_mps - speed_mps) < 2.0 * speed.std_mps;
        EXPECT_LT(std::abs(speed.speed_mps - speed_mps), 4.0 * speed.std_mps)
            << fade_deg << " degrees, " << period_s << " s, " << speed_mps << " m/s";
      }
      EXPECT_GE(inside, kTrials - 4) << fade_deg << " degrees, " << period_s << " s";
    }
}

// In pieces as short as the light's bends ask for.
TEST(DelayLight, AViewThatFadesOutIsFollowedToItsRim) {
  constexpr int kTrials = 16;
  constexpr double kFade_deg = 15.0, kNoise_w = 3e-3;
  constexpr double kMedianSigma = 5.4e-4;  // relative; 5.9e-4 where poor pieces stay whole
  const Site site = simulated::two_photodiodes(2.0, 0.0);
  Random random(13);
  std::vector<double> shares;
  for (int trial = 0; trial < kTrials; ++trial) {
    const double speed_mps = random.uniform(8.0, 35.0);
    const auto outcome =
        coming(speed_mps, 60.0, kNoise_w, 1e-3, fading_w(kFade_deg), random).speed(site);
    ASSERT_TRUE(std::holds_alternative<DelayFit>(outcome)) << trial;
    const SpeedEstimate& speed = std::get<DelayFit>(outcome).speed;
    shares.push_back(std::get<DelayFit>(outcome).own_std_mps() / speed.speed_mps);
    EXPECT_LT(std::abs(speed.speed_mps - speed_mps), 4.0 * speed.std_mps) << speed_mps << " m/s";
  }
  std::sort(shares.begin(), shares.end());
  EXPECT_LT(shares[kTrials / 2], kMedianSigma);
}

// A bar before each photodiode parts the light into stretches, of which each keeps another.
TEST(DelayLight, StretchesOfDifferentTimesGiveNone) {
  constexpr double kNoise_w = 1e-3;
  Random random(6);
  Pair pair = vanishing(20.0, 60.0, 2.0, kNoise_w, random);
  for (std::size_t i = 0; i < pair.near.time_s.size(); ++i) {
    const bool late = pair.near.time_s[i] > 1.5;
    (late ? pair.near : pair.far).power_w[i] = static_cast<float>(kNoise_w * random.normal());
  }
  const Site site = simulated::two_photodiodes(2.0);
  const auto problem = delay_problem(site, pair.near, pair.far, 0.0, 3.0, false);
  ASSERT_TRUE(std::holds_alternative<Miss>(problem));
  EXPECT_EQ(std::get<Miss>(problem), Miss::bad_fit);
}

}  // namespace
}  // namespace vildar
