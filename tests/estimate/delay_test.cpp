#include <gtest/gtest.h>

#include "delay_bound.h"
#include "delay_pair.h"
#include "estimate/light_checks.h"
#include "estimate/vehicle.h"

namespace vildar {
namespace {

using simulated::Pair;
using simulated::pair_of;
using simulated::Receiving;

Site beside_a_mast() {
  Site site = simulated::two_photodiodes(2.0);
  site.camera = simulated::mast_site(4.0).camera;
  return site;
}

TEST(Delay, SpeedAndAccelerationNeedNothingButTheBaseline) {
  const Site site = simulated::two_photodiodes(2.0);
  for (const double acceleration_mps2 : {0.0, 1.5, -1.5}) {
    simulated::Vehicle vehicle;
    vehicle.acceleration_mps2 = acceleration_mps2;
    const auto outcome = pair_of(vehicle, site, {.snr_db = 60.0}).speed(site);
    ASSERT_TRUE(std::holds_alternative<DelayFit>(outcome));
    const auto& fit = std::get<DelayFit>(outcome);
    const double truth_mps = vehicle.speed_at_mps(fit.speed.time_s);
    EXPECT_NEAR(fit.speed.speed_mps / truth_mps, 1.0, 0.002);
    EXPECT_LT(std::abs(fit.speed.speed_mps - truth_mps), 4.0 * fit.speed.std_mps);
    EXPECT_LT(std::abs(fit.acceleration_mps2 - acceleration_mps2), 4.0 * fit.acceleration_std_mps2);
    EXPECT_LT(fit.acceleration_std_mps2, 0.2);
  }
}

// Two like curves, known in every sample: their lag is known to the noise of a difference over the
// root of the summed squares of the slopes.
TEST(DelayBound, IsThatOfTheLagOfTwoLikeCurves) {
  constexpr double kNear = 0.03;  // the two are not of quite one stretch of road
  const Site site = simulated::two_photodiodes(2.0);
  const simulated::Vehicle vehicle{.along_m = 60.0};
  const simulated::Beam beam;
  const simulated::Receiving receiving;
  const Eigen::Vector3d near_m(0.0, 0.0, 4.0), far_m(2.0, 0.0, 4.0);
  const auto light = [&](double t_s) {
    return simulated::beam_power(vehicle, site.road, beam, near_m, t_s);
  };
  const double far = simulated::beam_power(vehicle, site.road, beam, far_m, 0.0);
  const double sigma = std::hypot(light(0.0), far) * std::pow(10.0, -receiving.snr_db / 20.0);
  constexpr double kStep_s = 1e-4;
  double slopes2 = 0.0;
  for (double t_s = 0.0; t_s < 3.0; t_s += 1e-3)
    slopes2 += std::pow((light(t_s + kStep_s) - light(t_s - kStep_s)) / (2.0 * kStep_s), 2);
  const double lag_std_s = sigma / std::sqrt(slopes2);
  const simulated::DelayBound bound(vehicle, site, beam, receiving, {.acceleration_std_mps2 = 0.0});
  EXPECT_NEAR(bound.relative_speed(2.0) / (lag_std_s * vehicle.speed_mps / 2.0), 1.0, kNear);
}

TEST(Delay, ABrakingThatBeginsInViewDoesNotBendTheSpeed) {
  const Site site = simulated::two_photodiodes(2.0);
  simulated::Vehicle vehicle;
  vehicle.speed_mps = 28.0;
  for (const double change_mps2 : {-1.0, -4.0, 2.0}) {
    vehicle.changes = {{0.8, change_mps2}};
    const auto fit = std::get<DelayFit>(pair_of(vehicle, site, {.snr_db = 60.0}).speed(site));
    const double error_mps = fit.speed.speed_mps - vehicle.speed_at_mps(fit.speed.time_s);
    EXPECT_LT(std::abs(error_mps), 3.0 * fit.speed.std_mps) << change_mps2;
    EXPECT_LT(fit.own_std_mps(), 0.005 * fit.speed.speed_mps);
    EXPECT_LT(std::abs(fit.acceleration_mps2 - change_mps2), 4.0 * fit.acceleration_std_mps2);
  }
}

// Far from any constant acceleration, which the fit starts from.
TEST(Delay, HardBrakingAndDrivingOnAreFollowed) {
  const Site site = simulated::two_photodiodes(2.0);
  for (const double braking_mps2 : {-3.5, -4.0, -4.5}) {
    const simulated::Vehicle vehicle{.speed_mps = 14.5,
                                     .acceleration_mps2 = braking_mps2,
                                     .changes = {{1.0, 1.5}, {3.0, 2.0}, {4.0, 1.5}}};
    const auto outcome = pair_of(vehicle, site).speed(site);
    ASSERT_TRUE(std::holds_alternative<DelayFit>(outcome));
    const auto& fit = std::get<DelayFit>(outcome);
    const double truth_mps = vehicle.speed_at_mps(fit.speed.time_s);
    EXPECT_NEAR(fit.speed.speed_mps / truth_mps, 1.0, 0.02) << braking_mps2;
    EXPECT_LT(std::abs(fit.speed.speed_mps - truth_mps), 4.0 * fit.speed.std_mps) << braking_mps2;
    EXPECT_LT(fit.chi2_per_dof, 1.2) << braking_mps2;
  }
}

TEST(Delay, TheCurveFollowsTheWholePulseWhateverTheAcceleration) {
  constexpr double kAlikeChi2 = 1.4;  // four sigmas of some 200 degrees of freedom
  const Site site = simulated::two_photodiodes(2.0);
  for (const std::uint64_t seed : {0, 1, 2, 184, 454}) {
    Random random(seed);
    const simulated::Vehicle vehicle{.speed_mps = random.uniform(26.0, 35.0),
                                     .acceleration_mps2 = random.uniform(-3.0, 3.0)};
    const simulated::Beam beam = simulated::random_beam(0.3, random);
    const PowerTrace near = simulated::beam_trace(vehicle, site, beam, 0, {}, random);
    const PowerTrace far = simulated::beam_trace(vehicle, site, beam, 1, {}, random);
    const auto problem = delay_problem(site, near, far, 0.0, 8.0, false);
    ASSERT_TRUE(std::holds_alternative<DelayProblem>(problem)) << seed;
    const auto outcome = fit_delay(std::get<DelayProblem>(problem));
    const auto* fit = std::get_if<DelayFit>(&outcome);
    ASSERT_TRUE(fit) << seed;
    EXPECT_LT(fit->chi2_per_dof, kAlikeChi2) << seed;
  }
}

VehicleResult pass_result(const Site& site, const Pair& pair, const simulated::Vehicle& vehicle) {
  const std::array<PowerTrace, 2> traces{pair.near, pair.far};
  const double abeam_s = vehicle.along_m / vehicle.speed_mps;
  return estimate_pass({0.0, abeam_s + 0.5, abeam_s - 0.5}, 1, site, traces);
}

TEST(Delay, APassSaysWhyThePairGaveNoSpeed) {
  Site site = simulated::two_photodiodes(2.0);
  const simulated::Vehicle vehicle;
  EXPECT_FALSE(pass_result(site, pair_of(vehicle, site), vehicle).withheld);
  // Ten times as far apart as they are.
  const VehicleResult fast =
      pass_result(simulated::two_photodiodes(20.0), pair_of(vehicle, site), vehicle);
  EXPECT_EQ(fast.withheld, Miss::outside_model)
      << fast.speed.speed_mps << " +- " << fast.speed.std_mps;
  ASSERT_FALSE(fast.warnings.empty());
  EXPECT_NE(fast.warnings.back().find("faster than vehicles drive"), std::string::npos);
  for (const MethodResult& row : fast.methods)
    if (row.method == Method::delay_photodiodes) {
      EXPECT_EQ(std::get<Miss>(row.speed), Miss::outside_model);
    }
  // Gains that the site denies.
  const VehicleResult denied = pass_result(site, pair_of(vehicle, site, {}, 1.5), vehicle);
  EXPECT_EQ(denied.withheld, Miss::sensors_contradict);
  ASSERT_FALSE(denied.warnings.empty());
  EXPECT_NE(denied.warnings.back().find("gain_ratio"), std::string::npos);
  // One that looks aside; that no channel is given is not the reason.
  site.photodiodes[1].yaw_rad = 0.3;
  EXPECT_EQ(pass_result(site, pair_of(vehicle, site), vehicle).withheld, Miss::outside_model);
}

// What lamps that pitch do: the light of both photodiodes changes at one time, not at one place.
TEST(Delay, LampsThatFadeInTimeGiveNoSpeed) {
  constexpr double kHz = 1.5, kShare = 0.05;
  const Site site = simulated::two_photodiodes(2.0);
  for (const double speed_mps : {12.0, 20.0, 28.0})
    for (const double phase_rad : {0.0, 1.5, 3.0, 4.5}) {
      const simulated::Vehicle vehicle{.speed_mps = speed_mps};
      Pair pair = pair_of(vehicle, site);
      const auto measured = [&] { return !pass_result(site, pair, vehicle).withheld; };
      EXPECT_TRUE(measured()) << speed_mps;
      for (PowerTrace* trace : {&pair.near, &pair.far})
        for (std::size_t i = 0; i < trace->time_s.size(); ++i) {
          const double fade = kShare * std::sin(2.0 * kPi * kHz * trace->time_s[i] + phase_rad);
          trace->power_w[i] += static_cast<float>(fade * (trace->power_w[i] - trace->ambient_w));
        }
      EXPECT_FALSE(measured()) << speed_mps << " " << phase_rad;
    }
}

TEST(Delay, TheSpeedIsThatOfATimeAskedFor) {
  const Site site = simulated::two_photodiodes(2.0);
  const simulated::Vehicle vehicle{.speed_mps = 28.0, .acceleration_mps2 = -2.0};
  const Pair pair = pair_of(vehicle, site, {.snr_db = 60.0});
  const auto best = std::get<DelayFit>(pair.speed(site));
  const double to_s = best.speed.time_s - 0.3;
  const auto fit = std::get<DelayFit>(pair.speed(site, to_s - 0.2, to_s));
  EXPECT_GE(fit.speed.time_s, to_s - 0.2);
  EXPECT_LE(fit.speed.time_s, to_s);
  EXPECT_GT(fit.speed.std_mps, best.speed.std_mps);
  EXPECT_LT(std::abs(fit.speed.speed_mps - vehicle.speed_at_mps(fit.speed.time_s)),
            4.0 * fit.speed.std_mps);
}

// Faint light far away tells the acceleration less well than its noise says, and the response to
// unlike angles passes zero somewhere on the way there, which makes no time a sure one.
TEST(Delay, FarFromTheBrightEndTheAccelerationIsDoubted) {
  const simulated::Vehicle vehicle{.speed_mps = 20.0, .along_m = 120.0};
  constexpr double kAsked_s = 3.0;  // 60 m off
  for (const double ratio_std : {0.0, 0.002, 0.01}) {
    const Site site = simulated::two_photodiodes(2.0, ratio_std);
    const Pair pair = pair_of(vehicle, site, {.snr_db = 70.0});
    const auto outcome = pair.speed(site, kAsked_s, kAsked_s);
    ASSERT_TRUE(std::holds_alternative<DelayFit>(outcome)) << ratio_std;
    const auto& fit = std::get<DelayFit>(outcome);
    EXPECT_NEAR(fit.speed.time_s, kAsked_s, 1e-9);
    EXPECT_GT(fit.surest_s, vehicle.along_m / vehicle.speed_mps - 1.0) << "where light is bright";
    EXPECT_GE(fit.speed.std_mps, kDelayAccelerationDoubt_mps2 * (fit.surest_s - kAsked_s))
        << ratio_std;
  }
}

TEST(Delay, WhatTheSiteSaysOfUnlikeAnglesDoesNotMoveTheMomentThatNoiseLeavesSurest) {
  constexpr double kEnd_s = 5.0, kGrid_s = kEnd_s / 32.0;
  const simulated::Vehicle vehicle{.speed_mps = 15.0, .along_m = 80.0};  // abeam after the end
  const auto surest_s = [&](double ratio_std) {
    const Site site = simulated::two_photodiodes(2.0, ratio_std);
    Pair pair = pair_of(vehicle, site);
    for (PowerTrace* trace : {&pair.near, &pair.far}) {
      const auto end = std::ranges::lower_bound(trace->time_s, kEnd_s) - trace->time_s.begin();
      trace->time_s.resize(end);
      trace->power_w.resize(end);
    }
    return std::get<DelayFit>(pair.speed(site)).surest_s;
  };
  const double alike_s = surest_s(0.0);
  for (const double ratio_std : {0.002, 0.01, 0.05})
    EXPECT_NEAR(surest_s(ratio_std), alike_s, kGrid_s) << ratio_std;
}

// By a camera that sees the vehicle until then as well.
VehicleResult beside_camera(const simulated::Vehicle& vehicle, const Site& site, const Pair& pair,
                            double to_s) {
  Random random(5);
  const VehicleTrack track = simulated::track_of(vehicle, site, {.to_s = to_s}, random);
  const std::array<VehiclePower, 2> power{VehiclePower{&pair.near, false},
                                          VehiclePower{&pair.far, false}};
  return estimate_vehicle(track, site, power).result;
}

// The camera has lost the vehicle by then, and its bearings know nothing of it.
TEST(Delay, ABrakingThatBeginsBehindTheCamerasViewDoesNotBendTheSpeed) {
  const Site site = beside_a_mast();
  for (const double change_mps2 : {-3.0, -6.0}) {
    const simulated::Vehicle vehicle{.speed_mps = 20.0, .changes = {{2.0, change_mps2}}};
    const Pair pair = pair_of(vehicle, site);
    const VehicleResult result = beside_camera(vehicle, site, pair, 2.0);
    ASSERT_FALSE(result.withheld) << change_mps2;
    EXPECT_EQ(result.method, Method::fused) << change_mps2;
    const double error_mps = result.speed.speed_mps - vehicle.speed_at_mps(result.speed.time_s);
    EXPECT_LT(std::abs(error_mps), 3.0 * result.speed.std_mps) << change_mps2;
  }
}

// Of two oncoming lanes the light alone could be of two vehicles.
TEST(Delay, ABrakingThatTheCameraSawIsOneVehicle) {
  Site site = simulated::two_photodiodes(2.0);
  site.road.lanes.push_back({"far", {-7.5, 0.3}, 3.5, Direction::oncoming});
  const simulated::Vehicle vehicle{.speed_mps = 20.0, .changes = {{1.2, -3.0}}};
  const Pair pair = pair_of(vehicle, site, {.snr_db = 60.0});
  const auto alone = pair.speed(site);
  ASSERT_TRUE(std::holds_alternative<DelayFit>(alone));
  ASSERT_TRUE(of_several(std::get<DelayFit>(alone), 2, 0.0));
  site.camera = simulated::mast_site(4.0).camera;
  const VehicleResult result = beside_camera(vehicle, site, pair, 2.5);
  ASSERT_FALSE(result.withheld);
  EXPECT_EQ(result.method, Method::fused);
  const double error_mps = result.speed.speed_mps - vehicle.speed_at_mps(result.speed.time_s);
  EXPECT_LT(std::abs(error_mps), 3.0 * result.speed.std_mps);
}

// Beside the one lane told, by both sensors' account.
TEST(Delay, HowSureNoLaneIsStaysAProbability) {
  const Site site = beside_a_mast();
  const simulated::Vehicle vehicle{.lateral_m = -8.0};
  const Pair pair = pair_of(vehicle, site);
  const VehicleResult result = beside_camera(vehicle, site, pair, 2.0);
  EXPECT_EQ(result.method, Method::fused);
  EXPECT_GT(result.no_lane_probability, 0.7);
  EXPECT_LE(result.no_lane_probability, 1.0 + 1e-12);
}

// What is left of the light once the rise is clipped is its end, of which the edge tells nothing.
TEST(Delay, OfLightThatIsMostlyClippedNoneIsToldBesideACamera) {
  const Site site = beside_a_mast();
  const simulated::Vehicle vehicle;
  Pair pair = pair_of(vehicle, site);
  for (PowerTrace* trace : {&pair.near, &pair.far}) {
    const double to_s = 0.9 * trace->time_s.back();
    trace->clipped = {{trace->time_s.front(), to_s}};
    const auto end = std::ranges::lower_bound(trace->time_s, to_s) - trace->time_s.begin();
    trace->time_s.erase(trace->time_s.begin() + 1, trace->time_s.begin() + end);
    trace->power_w.erase(trace->power_w.begin() + 1, trace->power_w.begin() + end);
  }
  const VehicleResult result = beside_camera(vehicle, site, pair, 2.0);
  EXPECT_FALSE(result.withheld);
  const auto row =
      std::ranges::find(result.methods, Method::delay_photodiodes, &MethodResult::method);
  ASSERT_NE(row, result.methods.end());
  EXPECT_EQ(std::get<Miss>(row->speed), Miss::saturated);
}

TEST(Delay, TracesThatEndBeforeTheVehicleComesTellNothing) {
  const Site site = beside_a_mast();
  const simulated::Vehicle vehicle;
  Pair pair = pair_of(vehicle, site);
  for (PowerTrace* trace : {&pair.near, &pair.far}) {
    trace->time_s.clear();
    trace->power_w.clear();
  }
  const VehicleResult result = beside_camera(vehicle, site, pair, 2.0);
  EXPECT_FALSE(result.withheld);
  EXPECT_EQ(result.method, Method::geometry_camera);
}

TEST(Delay, SpeedGoesWithTheBaselineAndItsSigmaWithBoth) {
  const Site site = simulated::two_photodiodes(2.0);
  const Site stretched = simulated::two_photodiodes(4.0, 0.002, 0.04);
  const Pair pair = pair_of({}, site);
  const auto one = std::get<DelayFit>(pair.speed(site));
  const auto other = std::get<DelayFit>(pair.speed(stretched));
  constexpr double kPriorOnAcceleration = 2e-3;  // it alone does not scale
  EXPECT_NEAR(other.speed.speed_mps / one.speed.speed_mps, 2.0, kPriorOnAcceleration);
  // Nor does how the driver drifts to the side.
  const auto relative = [](const DelayFit& fit) { return fit.own_std_mps() / fit.speed.speed_mps; };
  EXPECT_NEAR(relative(other), std::hypot(relative(one), 0.01), 5e-4);
}

// 4 cm to and fro within six seconds, beside photodiodes ten metres apart, whose noise tells the
// speed to a thousandth.
TEST(Delay, WhoDriftsToTheSideIsWithinTheSigma) {
  const Site site = simulated::two_photodiodes(10.0);
  int far = 0;
  for (const double phase_rad : {0.0, 1.0, 2.0, 3.0, 4.0, 5.0}) {
    simulated::Vehicle vehicle;
    vehicle.weave = {0.04, 6.0, phase_rad};
    const auto fit = std::get<DelayFit>(pair_of(vehicle, site, {.snr_db = 60.0}).speed(site));
    const double off_mps = fit.speed.speed_mps - vehicle.speed_at_mps(fit.speed.time_s);
    EXPECT_LT(std::abs(off_mps), 2.5 * fit.speed.std_mps) << phase_rad;
    far += std::abs(off_mps) > 3.0 * fit.own_std_mps();
  }
  EXPECT_GE(far, 2);  // of its sigma without
}

TEST(Delay, AGainRatioIsFoundAndDoesNotBendTheSpeed) {
  const Site site = simulated::two_photodiodes(2.0, 0.05);
  const simulated::Vehicle vehicle;
  const auto fit = std::get<DelayFit>(pair_of(vehicle, site, {.snr_db = 60.0}, 1.04).speed(site));
  EXPECT_NEAR(fit.log_ratio, std::log(1.04), 4.0 * fit.log_ratio_std);
  EXPECT_NEAR(fit.speed.speed_mps, vehicle.speed_at_mps(fit.speed.time_s), 4.0 * fit.speed.std_mps);
}

TEST(Delay, AGainThatTheSiteDeniesDoesNotBendTheSpeed) {
  constexpr double kStated = 0.002;
  const Site site = simulated::two_photodiodes(2.0, kStated);
  for (const double gain : {0.97, 0.99, 1.01, 1.03})
    for (const double speed_mps : {12.0, 20.0, 33.0}) {
      const simulated::Vehicle vehicle{.speed_mps = speed_mps};
      const auto outcome = pair_of(vehicle, site, {}, gain).speed(site);
      const auto* fit = std::get_if<DelayFit>(&outcome);
      if (!fit) {
        EXPECT_GT(std::abs(gain - 1.0), 10.0 * kStated) << "withheld where it need not be";
        EXPECT_EQ(std::get<Miss>(outcome), Miss::sensors_contradict);
        continue;
      }
      const double error_mps = fit->speed.speed_mps - vehicle.speed_at_mps(fit->speed.time_s);
      EXPECT_LT(std::abs(error_mps), 4.0 * fit->speed.std_mps) << gain << " " << speed_mps;
    }
}

TEST(Delay, AMismatchThatGrowsWithTheAngleIsInTheSigma) {
  constexpr double kMismatch = 0.01;
  const Site site = simulated::two_photodiodes(2.0, kMismatch);
  const simulated::Vehicle vehicle;
  for (const double mismatch : {-kMismatch, 0.0, kMismatch}) {
    const Pair pair = pair_of(vehicle, site, {.snr_db = 60.0}, 1.0, mismatch);
    const auto fit = std::get<DelayFit>(pair.speed(site));
    const double error_mps = fit.speed.speed_mps - vehicle.speed_at_mps(fit.speed.time_s);
    EXPECT_LT(std::abs(error_mps), 2.0 * fit.speed.std_mps) << mismatch;
  }
  // Photodiodes said to be alike are surer.
  const Site alike = simulated::two_photodiodes(2.0, 0.0);
  const Pair pair = pair_of(vehicle, site, {.snr_db = 60.0});
  EXPECT_LT(2.0 * std::get<DelayFit>(pair.speed(alike)).own_std_mps(),
            std::get<DelayFit>(pair.speed(site)).own_std_mps());
}

TEST(Delay, AMismatchFarBeyondWhatTheSiteSaysGivesNoWildSpeed) {
  constexpr double kSaid = 0.02, kUnlike = 0.1;
  const Site site = simulated::two_photodiodes(2.0, kSaid);
  const simulated::Vehicle vehicle{.speed_mps = 21.0};
  int measured = 0;
  for (const double tilt : {0.5, 4.0, 6.0, 9.0}) {
    const Pair pair =
        pair_of(vehicle, site, {}, 1.0, kUnlike, simulated::Beam{.width = 9.0, .tilt = tilt});
    const auto outcome = pair.speed(site);
    const auto* fit = std::get_if<DelayFit>(&outcome);
    if (!fit) continue;
    ++measured;
    const double truth_mps = vehicle.speed_at_mps(fit->speed.time_s);
    EXPECT_LT(std::abs(fit->speed.speed_mps - truth_mps), 2.0 * fit->speed.std_mps)
        << "tilt " << tilt;
    EXPECT_LT(std::abs(fit->speed.speed_mps / truth_mps - 1.0), 1.2 * kUnlike) << "tilt " << tilt;
  }
  EXPECT_GE(measured, 2) << "not by giving none";
}

TEST(Delay, WhatItCannotDoIsNamed) {
  Site site = simulated::two_photodiodes(2.0);
  const Pair pair = pair_of({}, site);
  const auto miss = [&](const Site& changed) { return std::get<Miss>(pair.speed(changed)); };
  Site higher = site;
  higher.photodiodes[1].position_m[2].mean = 4.2;
  EXPECT_EQ(miss(higher), Miss::outside_model);
  Site turned = site;
  turned.photodiodes[1].yaw_rad = 0.2;
  EXPECT_EQ(miss(turned), Miss::outside_model);
  Site curved = site;
  curved.road.kind = RoadKind::curved;
  EXPECT_EQ(miss(curved), Miss::outside_model);
  Site together = site;
  together.photodiodes[1].position_m[0].mean = 0.0;
  EXPECT_EQ(miss(together), Miss::no_scale);
  const std::array<const PowerTrace*, 1> alone{&pair.near};
  EXPECT_EQ(std::get<Miss>(delay_speed(site, alone, 0.0, 8.0)), Miss::no_scale);
}

TEST(Delay, PulsesThatAreNotAlikeAreRefusedOrVeryUncertain) {
  const Site site = simulated::two_photodiodes(2.0);
  simulated::Vehicle other;
  other.speed_mps = 12.0;
  Pair pair = pair_of({}, site);
  pair.far = pair_of(other, site).far;
  const auto outcome = pair.speed(site);
  if (const auto* fit = std::get_if<DelayFit>(&outcome)) {
    EXPECT_GT(fit->speed.std_mps, 0.25 * fit->speed.speed_mps);
  }
}

// Blocks of sparse samples are as long as the last part of the pulse, of which each could then have
// a curve of its own.
TEST(Delay, SparseSamplesGiveNoWildSpeed) {
  constexpr double kBaseline_m = 2.0, kNoise_w = 3e-11, kDown_m = 3.35;
  const Site site = simulated::two_photodiodes(kBaseline_m);
  Random random(11);
  int measured = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const double rate_hz = trial % 2 == 0 ? 50.0 : 100.0;
    const double speed_mps = random.uniform(25.0, 45.0), from_m = random.uniform(100.0, 150.0);
    const double late_s = random.uniform(0.0, 1.0 / rate_hz);
    Pair pair;
    for (const auto& [trace, photodiode] : {std::pair(&pair.near, 0), std::pair(&pair.far, 1)}) {
      trace->photodiode = photodiode;
      trace->sample_period_s = 1.0 / rate_hz;
      trace->noise_sigma_w = trace->ambient_sigma_w = kNoise_w;
      for (double t_s = late_s; t_s < from_m / speed_mps + 0.5; t_s += 1.0 / rate_hz) {
        const double ahead_m = from_m - speed_mps * t_s - kBaseline_m * photodiode;
        double light_w = random.normal(0.0, kNoise_w);
        for (const double aside_m : {3.4, 4.6})
          if (ahead_m > 0.0) {
            const double away2_m2 = ahead_m * ahead_m + aside_m * aside_m + kDown_m * kDown_m;
            light_w += 6e-6 * ahead_m * ahead_m * std::pow(away2_m2, -1.6);
          }
        trace->time_s.push_back(t_s);
        trace->power_w.push_back(static_cast<float>(light_w));
      }
    }
    const auto outcome = pair.speed(site);
    const auto* fit = std::get_if<DelayFit>(&outcome);
    if (!fit) continue;
    ++measured;
    EXPECT_LT(std::abs(fit->speed.speed_mps - speed_mps), 4.0 * fit->speed.std_mps)
        << trial << ": " << fit->speed.speed_mps << " of " << speed_mps;
  }
  EXPECT_GT(measured, 40);
}

}  // namespace
}  // namespace vildar
