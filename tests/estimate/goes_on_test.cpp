#include "estimate/goes_on.h"

#include <gtest/gtest.h>

#include <optional>
#include <utility>

#include "core/clock.h"
#include "estimate/one_place.h"
#include "simulated_pass.h"

namespace vildar {
namespace {

constexpr double kCut_s = 1.2;
const simulated::Vehicle kPasses{18.0, 0.0, 60.0, -4.0, 0.65, 1.2};

VehicleTrack seen(const simulated::Vehicle& vehicle, double from_s, double to_s) {
  Random random(3);
  VehicleTrack track =
      simulated::track_of(vehicle, simulated::mast_site(5.0), {.to_s = 4.0}, random);
  std::erase_if(track.sightings, [&](const VehicleSighting& sighting) {
    const double time_s = seconds_of(sighting.time);
    return time_s < from_s || time_s >= to_s;
  });
  return track;
}

VehicleEstimate measured(const VehicleTrack& track, const Site& site = simulated::mast_site(5.0)) {
  VehicleEstimate estimate = estimate_vehicle(track, site, {});
  EXPECT_FALSE(estimate.result.withheld) << name_of(*estimate.result.withheld);
  return estimate;
}

TEST(GoesOnAs, WhereATrackWasCutThatOfTheSameLamps) {
  const VehicleEstimate before = measured(seen(kPasses, 0.0, kCut_s));
  EXPECT_TRUE(goes_on_as(before, measured(seen(kPasses, kCut_s, 2.4))));
  EXPECT_FALSE(goes_on_as(measured(seen(kPasses, kCut_s, 2.4)), before));
  EXPECT_FALSE(goes_on_as(before, measured(seen(kPasses, kCut_s + 0.3, 2.4))));
}

// One lamp that is left, taken for the other side's.
TEST(GoesOnAs, TheLampThatIsLeftOnWhicheverSide) {
  VehicleTrack before = seen(kPasses, 0.0, kCut_s), after = seen(kPasses, kCut_s, 2.4);
  for (std::size_t i = before.sightings.size() - 3; i < before.sightings.size(); ++i)
    before.sightings[i].left.reset();
  after.sightings.front().left = std::exchange(after.sightings.front().right, std::nullopt);
  EXPECT_TRUE(goes_on_as(measured(before), measured(after)));
}

// One that follows by 8 m, or in the next lane.
TEST(GoesOnAs, NoOtherVehicle) {
  const VehicleEstimate before = measured(seen(kPasses, 0.0, kCut_s));
  simulated::Vehicle follows = kPasses, beside = kPasses;
  follows.along_m += 8.0;
  beside.lateral_m -= 3.5;
  for (const simulated::Vehicle& other : {follows, beside})
    EXPECT_FALSE(goes_on_as(before, measured(seen(other, kCut_s, 2.4))));
}

// Lengths are known to a tenth: where each of them is, to 5 m and more.
TEST(ComesOutAgain, OneThatWasHiddenForASecond) {
  constexpr double kAgain_s = 2.1;
  Site site = simulated::mast_site(5.0);
  site.lamps.height_m.reset();
  site.lamps.separation_m = Uncertain{1.2, 0.12};
  simulated::Vehicle car = kPasses;
  car.along_m = 90.0;
  const VehicleEstimate before = measured(seen(car, 0.0, 1.1), site);
  const VehicleEstimate after = measured(seen(car, kAgain_s, 3.4), site);
  EXPECT_FALSE(one_vehicle(before, after));
  EXPECT_TRUE(comes_out_again(before, after));
  EXPECT_FALSE(comes_out_again(after, before));
  EXPECT_FALSE(comes_out_again(before, measured(seen(car, 2.7, 4.0), site)));
  simulated::Vehicle follows = car, beside = car;
  follows.along_m += 10.0;
  beside.lateral_m -= 3.5;
  for (const simulated::Vehicle& other : {follows, beside})
    EXPECT_FALSE(comes_out_again(before, measured(seen(other, kAgain_s, 3.4), site)));
}

}  // namespace
}  // namespace vildar
