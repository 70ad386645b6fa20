#include "estimate/goes_on.h"

#include <gtest/gtest.h>

#include <optional>
#include <utility>

#include "core/clock.h"
#include "simulated_pass.h"

namespace vildar {
namespace {

constexpr double kCut_s = 1.2;
const simulated::Vehicle kPasses{18.0, 0.0, 60.0, -4.0, 0.65, 1.2};

VehicleTrack seen(const simulated::Vehicle& vehicle, double from_s, double to_s) {
  Random random(3);
  VehicleTrack track =
      simulated::track_of(vehicle, simulated::mast_site(5.0), {.to_s = 2.4}, random);
  std::erase_if(track.sightings, [&](const VehicleSighting& sighting) {
    const double time_s = seconds_of(sighting.time);
    return time_s < from_s || time_s >= to_s;
  });
  return track;
}

VehicleEstimate measured(const VehicleTrack& track) {
  return estimate_vehicle(track, simulated::mast_site(5.0), {});
}

TEST(GoesOnAs, WhereATrackWasCutThatOfTheSameLamps) {
  const VehicleEstimate before = measured(seen(kPasses, 0.0, kCut_s));
  EXPECT_TRUE(goes_on_as(before, measured(seen(kPasses, kCut_s, 3.0))));
  EXPECT_FALSE(goes_on_as(measured(seen(kPasses, kCut_s, 3.0)), before));
  EXPECT_FALSE(goes_on_as(before, measured(seen(kPasses, kCut_s + 0.3, 3.0))));
}

// One lamp that is left, taken for the other side's.
TEST(GoesOnAs, TheLampThatIsLeftOnWhicheverSide) {
  VehicleTrack before = seen(kPasses, 0.0, kCut_s), after = seen(kPasses, kCut_s, 3.0);
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
    EXPECT_FALSE(goes_on_as(before, measured(seen(other, kCut_s, 3.0))));
}

}  // namespace
}  // namespace vildar
