#include "estimate/delay_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include <gtest/gtest.h>

#include "delay_pair.h"
#include "estimate/delay_light.h"
#include "estimate/pass_delay.h"
#include "support/trials.h"

namespace vildar {
namespace {

using simulated::Pair;
using simulated::pair_of;
using simulated::Vehicle;

/// Tail lamps on the lane beyond, as bright at `nearest_m` as `share` of the pair's most light: by
/// the inverse square, from where they come into a view of 65 degrees to each side.
void add_tail_lamps(double share, double speed_mps, double passes_s, const Site& site, Pair& pair) {
  constexpr double kAside_m = 7.8;  // of 7 m and 3.4 m below
  const double edge_m = kAside_m / std::tan(radians_from_degrees(65.0));
  const double most_w = *std::ranges::max_element(pair.near.power_w) - pair.near.ambient_w;
  const double nearest2_m2 = kAside_m * kAside_m + edge_m * edge_m;
  for (PowerTrace* trace : {&pair.near, &pair.far}) {
    const double stands_m =
        site.photodiodes[static_cast<std::size_t>(trace->photodiode)].position_m[0].mean;
    for (std::size_t i = 0; i < trace->time_s.size(); ++i) {
      const double ahead_m = speed_mps * (trace->time_s[i] - passes_s) - stands_m;
      if (ahead_m > edge_m)
        trace->power_w[i] += static_cast<float>(share * most_w * nearest2_m2 /
                                                (kAside_m * kAside_m + ahead_m * ahead_m));
    }
  }
}

TEST(DelayParts, TailLampsThatPassTheOtherWayDoNotBendTheSpeed) {
  constexpr int kTrials = trials(40);
  const Site site = simulated::two_photodiodes(2.0);
  Random random(31);
  int measured = 0, inside = 0;
  double worst_sigmas = 0.0;
  for (int i = 0; i < kTrials; ++i) {
    Vehicle car;
    car.speed_mps = random.uniform(14.0, 32.0);
    car.acceleration_mps2 = random.normal(0.0, 0.4);
    Pair pair = pair_of(car, site, {.snr_db = 45.0});
    const double passed_s = pair.far.time_s.back();
    add_tail_lamps(random.uniform(0.005, 0.02), random.uniform(14.0, 32.0),
                   passed_s - random.uniform(0.5, 3.0), site, pair);
    const auto outcome = pair.speed(site);
    const auto* fit = std::get_if<DelayFit>(&outcome);
    if (!fit) continue;
    ++measured;
    const SpeedEstimate& speed = fit->speed;
    const double truth_mps = car.speed_at_mps(speed.time_s);
    inside += truth_mps > speed.lo95_mps && truth_mps < speed.hi95_mps;
    worst_sigmas = std::max(worst_sigmas, std::abs(speed.speed_mps - truth_mps) / speed.std_mps);
  }
  EXPECT_GE(measured, kTrials * 8 / 10);
  EXPECT_GE(inside, 0.95 * measured - 3.0 * std::sqrt(0.95 * 0.05 * measured));
  EXPECT_LT(worst_sigmas, 4.0);
}

// Of light that is dim all the while but for a flash at its peak no brighter part tells what is in
// it of others.
TEST(DelayParts, WhereNoBrightPartCanBeFittedNothingIsSaidOfOthers) {
  constexpr double kDim = 0.15;
  const Site site = simulated::two_photodiodes(2.0);
  const Pair pair = pair_of({}, site, {.snr_db = 45.0});
  auto posed = delay_problem(site, pair.near, pair.far, 0.0, 8.0, true);
  auto& problem = std::get<DelayProblem>(posed);
  const DelayFit fit = std::get<DelayFit>(fit_delay(problem));
  EXPECT_TRUE(spread_of_parts_mps(problem, fit));
  for (DelaySide* side : {&problem.near, &problem.far}) {
    const double ambient_w = side->ambient_w.mean;
    const double peak_w = std::ranges::max(side->blocks, {}, &PowerBlock::power_w).power_w;
    std::erase_if(side->blocks, [&](const PowerBlock& block) {
      return block.power_w - ambient_w > kDim * (peak_w - ambient_w) && block.power_w < peak_w;
    });
  }
  EXPECT_FALSE(spread_of_parts_mps(problem, fit));
}

// Tail lamps alone: on a road on which vehicles drive away they are no vehicle that comes.
TEST(DelayParts, LightThatFadesFromWhereItComesIntoViewIsOfTailLamps) {
  Site site = simulated::two_photodiodes(2.0);
  const Pair own = pair_of({}, site, {.snr_db = 45.0});
  Pair tails = own;
  constexpr double kPasses_s = 2.0;
  add_tail_lamps(0.2, 15.0, kPasses_s, site, tails);
  for (const auto& [trace, without] :
       {std::pair{&tails.near, &own.near}, std::pair{&tails.far, &own.far}})
    for (std::size_t i = 0; i < trace->power_w.size(); ++i)
      trace->power_w[i] += static_cast<float>(trace->ambient_w) - without->power_w[i];
  const std::array traces{tails.near, tails.far};
  const PowerPass pass{kPasses_s, kPasses_s + 2.0, kPasses_s + 0.25};
  const auto miss = [&](const Site& on) {
    const auto outcome = pass_delay(best_seen(pass, on, traces), on, traces, 1);
    const Miss* found = std::get_if<Miss>(&outcome);
    return found ? std::optional(*found) : std::nullopt;
  };
  EXPECT_NE(miss(site), Miss::several_vehicles);
  site.road.lanes.push_back({"far", {-7.0, 0.3}, 3.5, Direction::receding});
  EXPECT_EQ(miss(site), Miss::several_vehicles);
}

}  // namespace
}  // namespace vildar
