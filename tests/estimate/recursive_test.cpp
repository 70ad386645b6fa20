#include "estimate/recursive_fit.h"

#include <stdexcept>

#include <gtest/gtest.h>

#include "core/clock.h"
#include "estimate/mixture.h"
#include "estimate/vehicle.h"
#include "simulated_pass.h"

namespace vildar {
namespace {

constexpr simulated::View kView{.to_s = 2.2, .sigma_px = 0.1};

VehicleTrack seen(const simulated::Vehicle& vehicle, const Site& site,
                  const simulated::View& view = kView) {
  Random random(11);
  return simulated::track_of(vehicle, site, view, random);
}

TEST(Recursive, FirstEstimateComesAfterAThirdOfASecond) {
  const Site site = simulated::mast_site(4.0);
  const VehicleTrack track = seen({}, site);
  RecursiveFit live(site, track);
  EXPECT_EQ(std::get<Miss>(live.speed()), Miss::too_short);
  EXPECT_FALSE(live.state());
  std::optional<double> first_s;
  for (const VehicleSighting& sighting : track.sightings) {
    live.add(sighting);
    if (!first_s && live.state()) first_s = seconds_of(sighting.time);
  }
  ASSERT_TRUE(first_s);
  constexpr double kFrame_s = 1.0 / 30.0;
  EXPECT_LE(*first_s, 1.0 / 3.0 + kFrame_s + 1e-9);
}

TEST(Recursive, EndsWhereTheBatchFitDoes) {
  Site site = simulated::mast_site(4.0);
  for (const double acceleration_mps2 : {0.0, 2.0, -2.0}) {
    simulated::Vehicle vehicle;
    vehicle.acceleration_mps2 = acceleration_mps2;
    const VehicleTrack track = seen(vehicle, site);
    RecursiveFit live(site, track, {.jerk_mps2_per_root_s = 0.0});
    for (const VehicleSighting& sighting : track.sightings) live.add(sighting);
    std::vector<std::string> warnings;
    const auto batch = std::get<std::vector<Trajectory>>(
        fit_trajectories(track, Camera(*site.camera), site, warnings));
    const MotionState expected = mixed_state(batch, seconds_of(track.sightings.back().time));
    const MotionState found = *live.state();
    constexpr double kOfSigma = 0.15;  // what linearising once leaves
    EXPECT_NEAR(found.over_ground_mps, expected.over_ground_mps, kOfSigma * expected.speed_std_mps);
    EXPECT_NEAR(found.range_m, expected.range_m, kOfSigma * expected.range_std_m);
    EXPECT_NEAR(found.speed_std_mps / expected.speed_std_mps, 1.0, 0.05);
  }
}

// It has begun with one lamp, which is not the middle of the two.
TEST(Recursive, ALampThatAppearsBesideTheOneFollowedDoesNotPull) {
  const Site site = simulated::mast_site(4.0);
  const simulated::Vehicle vehicle;
  for (const bool left : {true, false}) {
    VehicleTrack track = seen(vehicle, site);
    for (VehicleSighting& sighting : track.sightings)
      if (seconds_of(sighting.time) < 1.6) (left ? sighting.right : sighting.left).reset();
    RecursiveFit live(site, track);
    for (const VehicleSighting& sighting : track.sightings) live.add(sighting);
    ASSERT_TRUE(live.state());
    EXPECT_NEAR(live.state()->over_ground_mps, vehicle.speed_mps, 0.03 * vehicle.speed_mps);
  }
}

TEST(Recursive, FollowsABrakingThatStartsLate) {
  const Site site = simulated::mast_site(4.0);
  // Two tracks of one vehicle, joined where it starts to brake.
  simulated::Vehicle before, after;
  constexpr double kBraking_s = 1.0, kRate_mps2 = -4.0;
  after.acceleration_mps2 = kRate_mps2;
  after.speed_mps = before.speed_mps - kRate_mps2 * kBraking_s;
  after.along_m = before.along_at_m(kBraking_s) + after.speed_mps * kBraking_s +
                  0.5 * kRate_mps2 * kBraking_s * kBraking_s;
  VehicleTrack track = seen(before, site);
  const VehicleTrack braking = seen(after, site);
  for (std::size_t i = 0; i < std::min(track.sightings.size(), braking.sightings.size()); ++i)
    if (seconds_of(track.sightings[i].time) > kBraking_s) track.sightings[i] = braking.sightings[i];
  RecursiveFit live(site, track, {.jerk_mps2_per_root_s = 3.0});
  for (const VehicleSighting& sighting : track.sightings) live.add(sighting);
  const double end_s = seconds_of(track.sightings.back().time);
  EXPECT_NEAR(live.state()->over_ground_mps, after.speed_at_mps(end_s), 1.0);
}

TEST(Recursive, AnOutlierIsTamed) {
  const Site site = simulated::mast_site(4.0);
  VehicleTrack track = seen({}, site);
  RecursiveFit clean(site, track);
  for (const VehicleSighting& sighting : track.sightings) clean.add(sighting);
  track.sightings[40].left->centre_px.x() += 30.0;
  RecursiveFit hit(site, track);
  for (const VehicleSighting& sighting : track.sightings) hit.add(sighting);
  EXPECT_NEAR(hit.state()->over_ground_mps, clean.state()->over_ground_mps, 0.02);
}

TEST(Recursive, NeedsACamera) {
  Site site = simulated::mast_site(4.0);
  site.camera.reset();
  EXPECT_THROW(RecursiveFit(site, VehicleTrack{}), std::invalid_argument);
}

}  // namespace
}  // namespace vildar
