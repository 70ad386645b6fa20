#include "estimate/flashers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "estimate/vehicle.h"
#include "simulated_pass.h"

namespace vildar {
namespace {

using simulated::mast_site;
using simulated::track_of;
using simulated::Vehicle;
using simulated::View;

constexpr Vehicle kPassing{.along_m = 70.0};
constexpr View kWholePass{.to_s = 2.8, .sigma_px = 0.3};
constexpr double kFlash_s = 0.7;

bool lit_at(double time_s) { return std::fmod(time_s, kFlash_s) < 0.5 * kFlash_s; }

/// The lamps' light grows and scatters by 2 %, times what `more` says.
VehicleTrack lamps_times(const std::function<double(double)>& more) {
  Random random(3);
  VehicleTrack track = track_of(kPassing, mast_site(5.0), kWholePass, random);
  for (VehicleSighting& one : track.sightings)
    for (LampSighting* lamp : {&*one.left, &*one.right}) {
      const double time_s = seconds_of(one.time);
      lamp->flux = 1e4 * std::exp(time_s) * more(time_s) * (1.0 + 0.02 * random.normal());
    }
  return track;
}

/// Indicators outside of the lamps, below them.
VehicleTrack with_indicators() {
  VehicleTrack track = lamps_times([](double time_s) { return lit_at(time_s) ? 1.3 : 1.0; });
  for (VehicleSighting& one : track.sightings) {
    if (!lit_at(seconds_of(one.time))) continue;
    one.left->centre_px += Eigen::Vector2d{-3.0, 1.0};
    one.right->centre_px += Eigen::Vector2d{3.0, 1.0};
  }
  return track;
}

int lamps_in(const VehicleTrack& track) {
  int lamps = 0;
  for (const VehicleSighting& one : track.sightings)
    lamps += one.left.has_value() + one.right.has_value();
  return lamps;
}

TEST(Flashers, ALampBesideALitOneSaysNothingOfItsPlace) {
  const auto outcome = estimate_vehicle(with_indicators(), mast_site(5.0), {}).result;
  ASSERT_FALSE(outcome.withheld);
  EXPECT_LT(std::abs(outcome.speed.speed_mps - kPassing.speed_mps), 2.5 * outcome.speed.std_mps);
}

TEST(Flashers, PlacesBetweenFlashesStay) {
  const VehicleTrack whole = without_flashes(with_indicators());
  for (const VehicleSighting& one : whole.sightings)
    EXPECT_FALSE(lit_at(seconds_of(one.time))) << seconds_of(one.time);
  EXPECT_NEAR(lamps_in(whole), 0.5 * lamps_in(with_indicators()), 6);
}

TEST(Flashers, ANeighbourOfALampThatFlashesStays) {
  VehicleTrack track = with_indicators();
  const VehicleTrack plain = lamps_times([](double) { return 1.0; });
  for (std::size_t k = 0; k < track.sightings.size(); ++k)
    track.sightings[k].right = plain.sightings[k].right;
  const VehicleTrack whole = without_flashes(track);
  ASSERT_EQ(whole.sightings.size(), track.sightings.size());
  for (const VehicleSighting& one : whole.sightings) {
    EXPECT_TRUE(one.right);
    EXPECT_EQ(one.left.has_value(), !lit_at(seconds_of(one.time))) << seconds_of(one.time);
  }
}

TEST(Flashers, LightThatDoesNotFlashStays) {
  const std::function<double(double)> kinds[] = {
      [](double) { return 1.0; },
      [](double time_s) { return time_s < 1.4 ? 1.0 : 1.4; },                  // full beam
      [](double time_s) { return time_s > 0.9 && time_s < 1.2 ? 0.5 : 1.0; },  // hidden once
      [](double time_s) { return 1.0 + 0.3 * std::sin(9.0 * time_s); },        // on springs
      [](double time_s) {  // pulsed, seen lit in every other picture
        return std::lround(time_s * kWholePass.frame_rate_hz) % 2 == 0 ? 1.4 : 1.0;
      }};
  for (std::size_t k = 0; k < std::size(kinds); ++k) {
    const VehicleTrack track = lamps_times(kinds[k]);
    EXPECT_EQ(lamps_in(without_flashes(track)), lamps_in(track)) << "kind " << k;
  }
}

constexpr View kAlone{.to_s = 2.8, .sigma_px = 0.1, .single_lamp = true};
constexpr Vehicle kSlowMotorcycle{.speed_mps = 14.0, .along_m = 65.0, .separation_m = 0.0};
constexpr int kCycle = 20;  // frames

// Lit for seven frames in twenty.
VehicleTrack blinking(const Site& site, bool stands) {
  Random random(1);
  VehicleTrack track = track_of(kSlowMotorcycle, site, kAlone, random);
  const std::vector<VehicleSighting> all = track.sightings;
  track.sightings.clear();
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (i % kCycle >= 7) continue;
    VehicleSighting seen = all[i];
    const VehicleSighting& first = all[i - i % kCycle];
    if (stands && seen.left) seen.left = first.left;
    if (stands && seen.right) seen.right = first.right;
    track.sightings.push_back(seen);
  }
  return track;
}

TEST(Flashers, LampsThatAreLitOneAfterAnotherAreNoVehicle) {
  const Site site = mast_site(5.0);
  const VehicleEstimate lights = estimate_vehicle(blinking(site, true), site, {});
  EXPECT_EQ(lights.result.withheld, Miss::not_on_road);
  EXPECT_TRUE(lit_in_turn(blinking(site, true)));
  const VehicleEstimate vehicle = estimate_vehicle(blinking(site, false), site, {});
  EXPECT_FALSE(vehicle.result.withheld);
}

// In a queue it goes on for a moment, and stands again.
TEST(Flashers, AVehicleThatCrawlsIsNotLitInTurn) {
  constexpr double kStep_px = 2.8;
  constexpr std::size_t kFrom = 30, kFrames = 5;
  Random random(2);
  VehicleTrack track = track_of(kSlowMotorcycle, mast_site(5.0), kAlone, random);
  for (std::size_t i = 0; i < track.sightings.size(); ++i) {
    VehicleSighting& one = track.sightings[i];
    const auto gone = static_cast<double>(std::min(std::max(i, kFrom) - kFrom, kFrames));
    for (auto* lamp : {&one.left, &one.right})
      if (*lamp) (*lamp)->centre_px = {300.0, 300.0 + kStep_px * gone};
  }
  EXPECT_FALSE(lit_in_turn(track));
}

}  // namespace
}  // namespace vildar
