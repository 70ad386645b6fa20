#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "delay_pair.h"
#include "support/trials.h"

namespace vildar {
namespace {

using simulated::Pair;
using simulated::pair_of;

/// A lamp whose light rises along a straight line, and is as bright until the end.
struct Lamp {
  double from_s = 0.0, rise_s = 0.01;
  double near_w = 0.0, far_w = 0.0;

  double share(double time_s) const { return std::clamp((time_s - from_s) / rise_s, 0.0, 1.0); }
};

void shine(const Lamp& lamp, Pair& pair) {
  for (const auto& [trace, power_w] :
       {std::pair(&pair.near, lamp.near_w), std::pair(&pair.far, lamp.far_w)})
    for (std::size_t i = 0; i < trace->time_s.size(); ++i)
      trace->power_w[i] += static_cast<float>(power_w * lamp.share(trace->time_s[i]));
}

TEST(CommonLight, ALampThatComesOnBesideAVehicleDoesNotBendItsSpeed) {
  constexpr int kVehicles = trials(24), kFewestTold = kVehicles - 3, kMostOutside = 2;
  constexpr double kMostRms = 0.02;  // alone, as if no lamp came on: 0.07
  const Site site = simulated::two_photodiodes(2.0);
  Random random(5);
  int told = 0, outside = 0;
  double square = 0.0;
  for (int k = 0; k < kVehicles; ++k) {
    const simulated::Vehicle vehicle{.speed_mps = random.uniform(10.0, 40.0),
                                     .acceleration_mps2 = random.normal(0.0, 0.4)};
    Pair pair = pair_of(vehicle, site);
    const double passes_s = vehicle.along_m / vehicle.speed_mps;
    const double bright_w = random.uniform(0.05, 0.5) *
                            (*std::ranges::max_element(pair.near.power_w) - pair.near.ambient_w);
    shine({passes_s * random.uniform(0.6, 0.9), random.uniform(0.01, 0.1), bright_w,
           bright_w * random.uniform(0.5, 1.0)},
          pair);
    const auto outcome = pair.speed(site);
    const auto* fit = std::get_if<DelayFit>(&outcome);
    if (!fit) continue;
    const SpeedEstimate& speed = fit->speed;
    const double truth_mps = vehicle.speed_at_mps(speed.time_s);
    ++told;
    outside += truth_mps < speed.lo95_mps || truth_mps > speed.hi95_mps;
    square += std::pow(speed.speed_mps / truth_mps - 1.0, 2);
  }
  EXPECT_GE(told, kFewestTold);
  EXPECT_LE(outside, kMostOutside);
  EXPECT_LT(std::sqrt(square / told), kMostRms);
}

// Of both together and one of them alone, what two photodiodes see has another shape.
TEST(CommonLight, LampsThatComeAndGoAreNoVehicle) {
  constexpr int kScenes = trials(10), kMostTold = 2;  // three where own light need not prevail
  const Site site = simulated::two_photodiodes(2.0);
  Random random(9);
  int told = 0;
  for (int k = 0; k < kScenes; ++k) {
    Pair pair = pair_of({.speed_mps = 10.0, .along_m = 2000.0}, site);
    for (const auto& trace : {&pair.near, &pair.far})
      std::ranges::generate(trace->power_w, [&] {
        return static_cast<float>(trace->ambient_w + random.normal(0.0, trace->noise_sigma_w));
      });
    for (int lamp = 0; lamp < 3; ++lamp) {
      const double from_s = random.uniform(1.0, 3.0), to_s = from_s + random.uniform(0.3, 1.0);
      const double rise_s = random.uniform(0.02, 0.15), bright = random.uniform(50.0, 200.0);
      const double near_w = random.uniform(0.1, 1.0) * bright * pair.near.noise_sigma_w,
                   far_w = random.uniform(0.1, 1.0) * bright * pair.near.noise_sigma_w;
      shine({from_s, rise_s, near_w, far_w}, pair);
      shine({to_s, rise_s, -near_w, -far_w}, pair);
    }
    told += std::holds_alternative<DelayFit>(pair.speed(site));
  }
  EXPECT_LE(told, kMostTold);
}

}  // namespace
}  // namespace vildar
