#include "estimate/lamp_size.h"

#include <cmath>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "core/clock.h"
#include "estimate/vehicle.h"
#include "simulated_pass.h"

namespace vildar {
namespace {

constexpr double kSize_px_m = 96.0;  // 0.06 m behind 1600 px
constexpr double kFlux_m2 = 3.0e6;   // light times distance squared
constexpr double kPerRadius = -1.3;

// A lamp as a fit finds it whose radius errs: light and radius go together at the rim.
LampLight seen_at(double distance_m, double error_px, double error_ln, double sigma_px) {
  LampLight light;
  light.radius_px = kSize_px_m / distance_m + error_px;
  light.radius_sigma_px = sigma_px;
  light.log_flux_per_radius = kPerRadius;
  light.log_flux_sigma_at_radius = 0.05;
  light.flux = kFlux_m2 / (distance_m * distance_m) * std::exp(kPerRadius * error_px + error_ln);
  light.flux_sigma = light.flux * std::hypot(0.05, kPerRadius * sigma_px);
  light.coded = true;
  return light;
}

TEST(HoldSize, TakesTheRadiusErrorOutOfTheLight) {
  constexpr double kRelative = 1e-12;
  const std::vector<double> distance_m{50.0, 50.0, 25.0};
  std::vector<LampLight> lights{seen_at(50.0, 0.1, 0.0, 0.08), seen_at(50.0, -0.1, 0.0, 0.08),
                                seen_at(25.0, 0.0, 0.0, 0.08)};
  hold_size(distance_m, lights);
  for (std::size_t i = 0; i < lights.size(); ++i) {
    EXPECT_NEAR(lights[i].radius_px * distance_m[i] / kSize_px_m, 1.0, kRelative);
    EXPECT_NEAR(lights[i].flux * distance_m[i] * distance_m[i] / kFlux_m2, 1.0, kRelative);
  }
}

TEST(HoldSize, TellsLightThatAPictureByItselfDoesNot) {
  const std::vector<double> distance_m{60.0, 20.0, 19.0};
  std::vector<LampLight> lights{seen_at(60.0, 0.3, 0.0, 0.3), seen_at(20.0, 0.02, 0.0, 0.05),
                                seen_at(19.0, -0.02, 0.0, 0.05)};
  EXPECT_FALSE(lights[0].told());
  hold_size(distance_m, lights);
  EXPECT_TRUE(lights[0].told());
  EXPECT_NEAR(lights[0].flux * 60.0 * 60.0 / kFlux_m2, 1.0, 0.02);
}

// A fit at the least radius there is knows nothing of how light goes with a radius eight times as
// large.
TEST(HoldSize, AStepFarFromTheFitIsNotTold) {
  const std::vector<double> distance_m{120.0, 20.0, 19.0};
  std::vector<LampLight> lights{seen_at(120.0, 0.0, 0.0, 1.0), seen_at(20.0, 0.0, 0.0, 0.05),
                                seen_at(19.0, 0.0, 0.0, 0.05)};
  lights[0].radius_px = 0.1;
  lights[0].log_flux_per_radius = -0.43;
  lights[0].log_flux_sigma_at_radius = 0.02;
  hold_size(distance_m, lights);
  EXPECT_NEAR(lights[0].radius_px, 0.8, 0.01);
  EXPECT_FALSE(lights[0].told());
  EXPECT_TRUE(lights[1].told());
}

TEST(HoldSize, DoesNotDependOnTheScaleOfTheDistances) {
  constexpr double kRelative = 1e-12;
  const std::vector<double> distance_m{50.0, 40.0, 25.0}, scaled_m{60.0, 48.0, 30.0};
  std::vector<LampLight> lights{seen_at(50.0, 0.1, 0.0, 0.08), seen_at(40.0, 0.02, 0.0, 0.06),
                                seen_at(25.0, -0.05, 0.0, 0.05)};
  std::vector<LampLight> same = lights;
  hold_size(distance_m, lights);
  hold_size(scaled_m, same);
  for (std::size_t i = 0; i < lights.size(); ++i) {
    EXPECT_NEAR(same[i].flux / lights[i].flux, 1.0, kRelative);
    EXPECT_NEAR(same[i].flux_sigma / lights[i].flux_sigma, 1.0, kRelative);
  }
}

// A pass from 70 to 15 m: each picture's radius errs by itself and all together by a shift.
TEST(HoldSize, IsBetterThanEachPictureAndItsSigmasHold) {
  constexpr int kTrials = 400, kPictures = 40;
  constexpr double kSigma_px = 0.1, kShift_px = 0.05, kSelf_ln = 0.05;
  constexpr double kSlack = 0.05;  // pictures of a pass share the shift: 1000 independent ones
  Random random(7);
  double alone2 = 0.0, held2 = 0.0;
  int covered = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const double shift_px = kShift_px * random.normal();
    std::vector<double> distance_m;
    std::vector<LampLight> lights;
    for (int i = 0; i < kPictures; ++i) {
      distance_m.push_back(70.0 - 55.0 * i / (kPictures - 1));
      lights.push_back(seen_at(distance_m.back(), shift_px + kSigma_px * random.normal(),
                               kSelf_ln * random.normal(), kSigma_px));
    }
    const auto error_ln = [&](std::size_t i) {
      return std::log(lights[i].flux * distance_m[i] * distance_m[i] / kFlux_m2);
    };
    for (std::size_t i = 0; i < lights.size(); ++i) alone2 += std::pow(error_ln(i), 2);
    hold_size(distance_m, lights);
    for (std::size_t i = 0; i < lights.size(); ++i) {
      held2 += std::pow(error_ln(i), 2);
      covered += std::abs(error_ln(i)) < 1.96 * lights[i].flux_sigma / lights[i].flux;
    }
  }
  EXPECT_LT(held2, 0.35 * alone2);  // 0.26 by these sigmas
  EXPECT_NEAR(covered / static_cast<double>(kTrials * kPictures), 0.95, kSlack);
}

TEST(HoldSize, RefusesLightsWithoutDistanceOrSigma) {
  std::vector<LampLight> lights{seen_at(50.0, 0.0, 0.0, 0.1)};
  const std::vector<double> none, one{50.0};
  EXPECT_THROW(hold_size(none, lights), std::invalid_argument);
  EXPECT_THROW(hold_size(none, {}), std::invalid_argument);
  lights[0].radius_sigma_px = 0.0;
  EXPECT_THROW(hold_size(one, lights), std::invalid_argument);
}

// A pass whose left lamp was fitted, its radius 0.1 px too large and too small in turns.
VehicleTrack fitted_track(const Site& site, bool coded) {
  constexpr simulated::Vehicle kVehicle{20.0, 0.0, 60.0, -4.0, 0.65, 1.2};
  constexpr simulated::View kView{.to_s = 2.0, .frame_rate_hz = 15.0, .sigma_px = 0.02};
  Random random(3);
  VehicleTrack track = simulated::track_of(kVehicle, site, kView, random);
  for (VehicleSighting& sighting : track.sightings) {
    const simulated::Lamps lamps =
        simulated::lamps_at(kVehicle, site.road, seconds_of(sighting.time));
    const double distance_m = (lamps.left_m - Camera(*site.camera).position_m()).norm();
    const double error_px = sighting.frame % 2 == 0 ? 0.1 : -0.1;
    sighting.left->lamp = seen_at(distance_m, error_px, 0.0, 0.1);
    sighting.left->lamp->coded = coded;
  }
  return track;
}

TEST(HeldSizes, OfCodedPicturesAreWhatARunReports) {
  constexpr double kRelative = 0.02;  // what 30 radii in turns and the fitted distances leave
  const Site site = simulated::mast_site(4.0);
  const VehicleTrack track = fitted_track(site, true);
  const VehicleEstimate estimate = estimate_vehicle(track, site, {});
  ASSERT_FALSE(estimate.result.withheld);
  for (const TrackRow& row : estimate.rows) {
    const LampSighting& left = *row.sighting.left;
    const double distance_m = kSize_px_m / left.lamp->radius_px;
    EXPECT_NEAR(left.lamp->flux * distance_m * distance_m / kFlux_m2, 1.0, kRelative);
    EXPECT_NEAR(row.intensity / (left.lamp->flux + row.sighting.right->flux), 1.0, 1e-12);
  }
}

TEST(HeldSizes, LeaveLosslessPicturesAsTheyAre) {
  const Site site = simulated::mast_site(4.0);
  const VehicleTrack track = fitted_track(site, false);
  const VehicleEstimate estimate = estimate_vehicle(track, site, {});
  for (std::size_t i = 0; i < track.sightings.size(); ++i)
    EXPECT_EQ(estimate.rows[i].sighting.left->lamp->flux, track.sightings[i].left->lamp->flux);
}

}  // namespace
}  // namespace vildar
