#include <algorithm>

#include <gtest/gtest.h>

#include "diode_pass.h"
#include "estimate/photodiode_speed.h"
#include "geometry_pass.h"

namespace vildar {
namespace {

using simulated::Diode;
using simulated::diode_site;
using simulated::kTypical;
using simulated::mast_site;
using simulated::matching_diode;
using simulated::method_of;
using simulated::speed_of;
using simulated::trace_of;
using simulated::track_of;
using simulated::Vehicle;
using simulated::View;

// Frames are few in these tests to keep the trajectory fit short.
constexpr View kExactView{.to_s = 2.0, .frame_rate_hz = 15.0, .sigma_px = 1e-7};
VehicleResult measured(const Site& site, const View& view, const PowerTrace* trace = nullptr,
                       bool shared = false) {
  Random random(1);
  const VehiclePower power{trace, shared};
  return estimate_vehicle(track_of(kTypical, site, view, random), site,
                          {&power, trace ? std::size_t{1} : std::size_t{0}})
      .result;
}

// The intensity is that of two lamps, whose mean inverse square differs from the middle's by half a
// thousandth at 25 m.
constexpr double kTwoLamps = 2e-3;

TEST(CameraIntensity, FindsTheSpeedWithItsOwnGain) {
  const VehicleResult result = measured(mast_site(4.0), kExactView);
  const MethodResult& row = method_of(result, Method::power_slope_camera);
  EXPECT_NEAR(speed_of(row) / 20.0, 1.0, kTwoLamps);
  EXPECT_EQ(row.k_source, "bearings");
  // Its scale is that of the bearings, so it cannot be surer than they are.
  EXPECT_GE(std::get<SpeedEstimate>(row.speed).std_mps, 0.9 * result.speed.std_mps);
}

TEST(CameraIntensity, FindsTheSpeedWithTheSitesGain) {
  Site site = mast_site(4.0);
  site.camera->gain_db = Uncertain{10.0 * std::log10(2000.0), 2.0};
  const VehicleResult result = measured(site, kExactView);
  const MethodResult& row = method_of(result, Method::power_slope_camera);
  EXPECT_NEAR(speed_of(row) / 20.0, 1.0, kTwoLamps);
  EXPECT_EQ(row.k_source, "site");
  // Far off, V goes as K^(1/gamma): two decibels are 0.461 nat, and gamma is 2.
  const double relative = std::get<SpeedEstimate>(row.speed).std_mps / 20.0;
  EXPECT_NEAR(relative, 0.5 * 0.461, 0.15 * 0.230);
}

TEST(CameraIntensity, IsWithheldWherePixelsClip) {
  const Site site = mast_site(4.0);
  Random random(1);
  VehicleTrack track = track_of(kTypical, site, kExactView, random);
  for (VehicleSighting& sighting : track.sightings) sighting.right->saturated_px = 3;
  const VehicleResult result = estimate_vehicle(track, site, {}).result;
  EXPECT_EQ(std::get<Miss>(method_of(result, Method::power_slope_camera).speed), Miss::saturated);
  EXPECT_FALSE(result.withheld);
}

// Only the part of a track that was measured tells how far the vehicle was.
TEST(CameraIntensity, TakesItsGainFromThePartThatWasMeasured) {
  const Site site = mast_site(4.0);
  Random random(1);
  const View view{.to_s = 2.4, .frame_rate_hz = 30.0, .sigma_px = 0.02};
  VehicleTrack track = track_of(kTypical, site, view, random);
  // The right lamp is at first that of another vehicle.
  for (VehicleSighting& sighting : track.sightings)
    if (seconds_of(sighting.time) < 0.6) sighting.right->centre_px += Eigen::Vector2d(40.0, 25.0);
  const VehicleResult result = estimate_vehicle(track, site, {}).result;
  ASSERT_FALSE(result.warnings.empty());
  EXPECT_LT(static_cast<std::size_t>(result.n_frames), track.sightings.size());
  const MethodResult& row = method_of(result, Method::power_slope_camera);
  EXPECT_LE(row.samples, result.n_frames);
  EXPECT_NEAR(speed_of(row) / 20.0, 1.0, 0.01);
}

TEST(PhotodiodePower, FindsTheSpeed) {
  const Site site = diode_site();
  Random random(1);
  const PowerTrace trace = trace_of(kTypical, site, matching_diode(), random);
  const VehicleResult result = measured(site, kExactView, &trace);
  EXPECT_NEAR(speed_of(method_of(result, Method::power_slope_photodiode)) / 20.0, 1.0, 1e-3);
}

TEST(PhotodiodePower, CarriesTheGainPriorIntoItsSigma) {
  Site site = diode_site();
  site.channel->gain_db->std = 1.0;
  Random random(1);
  const PowerTrace trace = trace_of(kTypical, site, matching_diode(), random);
  const VehicleResult result = measured(site, kExactView, &trace);
  const auto& speed =
      std::get<SpeedEstimate>(method_of(result, Method::power_slope_photodiode).speed);
  EXPECT_NEAR(speed.std_mps / 20.0, 0.2303 / 1.8, 0.15 * 0.128);
}

TEST(PhotodiodePower, SaysWhatIsMissing) {
  Random random(1);
  const PowerTrace trace = trace_of(kTypical, diode_site(), matching_diode(), random);
  const auto reason = [&](const Site& site, bool shared) {
    const VehicleResult result = measured(site, kExactView, &trace, shared);
    return std::get<Miss>(method_of(result, Method::power_slope_photodiode).speed);
  };
  EXPECT_EQ(reason(diode_site(), true), Miss::several_vehicles);
  Site site = diode_site();
  site.channel->gain_db.reset();
  EXPECT_EQ(reason(site, false), Miss::no_scale);
  site.channel.reset();
  EXPECT_EQ(reason(site, false), Miss::no_scale);
  site = diode_site();
  site.channel->beam = "low_beam";
  EXPECT_EQ(reason(site, false), Miss::outside_model);
}

TEST(Pass, FindsSpeedAndRangeInClipTime) {
  Site site = diode_site();
  site.camera.reset();
  site.photodiodes[0].time_offset_s.mean = 5.0;
  Diode diode = matching_diode();
  diode.time_offset_s = 5.0;
  diode.to_s = 3.5;
  Random random(1);
  const PowerTrace trace = trace_of(kTypical, site, diode, random);
  const PowerPass pass{-5.5, -1.6, -2.0};
  const VehicleResult result = estimate_pass(pass, 7, site, {&trace, 1});
  ASSERT_FALSE(result.withheld) << name_of(*result.withheld);
  EXPECT_EQ(result.track_id, 7);
  EXPECT_EQ(result.method, Method::power_slope_photodiode) << "not the surer one";
  EXPECT_NEAR(result.speed.speed_mps, 20.0, 0.02);
  EXPECT_NEAR(*result.range_ref_m, kTypical.along_at_m(result.speed.time_s), 0.05);
  EXPECT_NEAR(result.t_first_s, -0.5, 1e-12);
  EXPECT_TRUE(result.used_photodiode && !result.used_camera);
}

// A house, a crest or the rim of the photodiode's view: the block in which it comes out is lit in
// part.
TEST(Pass, OfAVehicleThatComesOutFromBehindSomethingTheRestTells) {
  Site site = diode_site();
  site.camera.reset();
  for (const double out_s : {1.0, 1.002, 1.005, 1.008}) {
    Random random(1);
    PowerTrace trace = trace_of(kTypical, site, matching_diode(), random);
    for (std::size_t i = 0; i < trace.time_s.size() && trace.time_s[i] < out_s; ++i)
      trace.power_w[i] = static_cast<float>(trace.ambient_w);
    const VehicleResult result = estimate_pass({0.98, 2.5, 2.4}, 1, site, {&trace, 1});
    ASSERT_FALSE(result.withheld) << out_s << " " << name_of(*result.withheld);
    for (const MethodResult& row : result.methods)
      EXPECT_NEAR(speed_of(row), 20.0, 0.3) << out_s << " " << name_of(row.method);
  }
}

// It had 2 to 4 m/s with sigmas of half of that and more, as it stood.
TEST(Pass, OfAVehicleThatStandsOnItsWayLightAloneTellsNoSpeed) {
  Site site = diode_site();
  site.camera.reset();
  for (const bool stops : {true, false}) {
    // From 40 m on 8 m/s, at rest 16 m off from 4 to 7 s, or down to 2 m/s.
    Vehicle vehicle = kTypical;
    vehicle.speed_mps = 8.0;
    vehicle.along_m = 40.0;
    vehicle.changes = {{2.0, stops ? -4.0 : -3.0}, {4.0, stops ? 4.0 : 3.0}, {7.0, 2.0}};
    Diode diode = matching_diode();
    diode.to_s = 10.5;
    Random random(1);
    const PowerTrace trace = trace_of(vehicle, site, diode, random);
    const VehicleResult result =
        estimate_pass({-0.5, 10.5, stops ? 10.5 : 9.0}, 1, site, {&trace, 1});
    const bool told = std::ranges::any_of(result.warnings, [](const std::string& warning) {
      return warning.find("the vehicle stands") != std::string::npos;
    });
    EXPECT_EQ(told, stops);
    EXPECT_EQ(result.withheld == Miss::outside_model, stops);
  }
}

TEST(Pass, OnARoadWithoutOncomingLanesTheVehicleDrivesAway) {
  Site site = diode_site();
  site.camera.reset();
  for (LaneSite& lane : site.road.lanes) lane.direction = Direction::receding;
  Random random(1);
  const PowerTrace trace = trace_of(kTypical, site, matching_diode(), random);
  const VehicleResult result = estimate_pass({-0.5, 2.5, 2.4}, 1, site, {&trace, 1});
  EXPECT_EQ(result.direction, Direction::receding);
  EXPECT_EQ(result.withheld, Miss::outside_model);
  ASSERT_FALSE(result.warnings.empty());
  EXPECT_NE(result.warnings.front().find("no lane of the site is oncoming"), std::string::npos);
}

TEST(Pass, IsWithheldWhereGainAndLaneAreTooVague) {
  Site site = diode_site();
  site.channel->gain_db->std = 5.0;
  site.road.lanes[0].lateral_m.std = 2.0;  // else the perpendicular distance gives the scale
  Random random(1);
  const PowerTrace trace = trace_of(kTypical, site, matching_diode(), random);
  const VehicleResult result = estimate_pass({-0.5, 2.5, 2.4}, 1, site, {&trace, 1});
  EXPECT_EQ(result.withheld, Miss::too_uncertain);
  EXPECT_TRUE(std::holds_alternative<SpeedEstimate>(result.methods.front().speed));
}

TEST(Pass, AnyOfSeveralLanesLiesInItsInterval) {
  Site site = diode_site();
  site.road.lanes.push_back({"far", {-7.5, 0.05}, 3.5, Direction::oncoming});
  for (const double lateral_m : {-4.0, -7.5}) {
    Vehicle vehicle = kTypical;
    vehicle.lateral_m = lateral_m;
    Random random(1);
    const PowerTrace trace = trace_of(vehicle, site, matching_diode(), random);
    const VehicleResult result = estimate_pass({-0.5, 2.5, 2.4}, 1, site, {&trace, 1});
    ASSERT_FALSE(result.withheld) << name_of(*result.withheld);
    EXPECT_LE(result.speed.lo95_mps, 20.0);
    EXPECT_GE(result.speed.hi95_mps, 20.0);
    EXPECT_EQ(result.lane, "");
    EXPECT_FALSE(result.lateral_m);
  }
}

// Twice the light looks like that of one nearer by, which drives slower.
TEST(Pass, OfTwoAbreastTheIntervalHoldsTheSpeed) {
  Site site = diode_site();
  site.channel->gain_db->std = 1.0;
  site.road.lanes.push_back({"far", {-4.5, 0.05}, 3.5, Direction::oncoming});
  Random random(1);
  PowerTrace trace = trace_of(kTypical, site, matching_diode(), random);
  for (float& power_w : trace.power_w)
    power_w = static_cast<float>(2.0 * power_w - trace.ambient_w);
  const VehicleResult result = estimate_pass({-0.5, 2.5, 2.4}, 1, site, {&trace, 1});
  ASSERT_FALSE(result.withheld) << name_of(*result.withheld);
  EXPECT_LT(result.speed.speed_mps, 0.8 * 20.0);
  EXPECT_GE(result.speed.hi95_mps, 20.0);
}

TEST(Pass, IsFollowedToThePeakOfTheLightThatIsUsed) {
  Site site = diode_site();
  Random random(1);
  PowerTrace trace = trace_of(kTypical, site, matching_diode(), random);
  // Found by another photodiode, which the vehicle reaches 0.1 s later.
  site.photodiodes.push_back(site.photodiodes.front());
  site.photodiodes[1].id = "down";
  site.photodiodes[1].position_m[0].mean = -2.0;
  constexpr double kGone_s = 2.35;
  for (std::size_t i = 0; i < trace.time_s.size(); ++i)
    if (trace.time_s[i] > kGone_s) trace.power_w[i] = static_cast<float>(trace.ambient_w);
  const VehicleResult result = estimate_pass(
      {.from_s = -0.5, .to_s = 2.5, .peak_s = 2.45, .photodiode = 1}, 1, site, {&trace, 1});
  ASSERT_GE(result.methods.size(), 2U);
  for (const MethodResult& row : result.methods) {
    const auto* speed = std::get_if<SpeedEstimate>(&row.speed);
    ASSERT_NE(speed, nullptr) << name_of(row.method) << " " << name_of(std::get<Miss>(row.speed));
    EXPECT_NEAR(speed->speed_mps, kTypical.speed_mps, 2.0 * speed->std_mps) << name_of(row.method);
  }
}

// Before it a slower vehicle of four times its light, which a photodiode 8 m up the road has lost
// when the pass begins there.
TEST(Pass, LightOfTheVehicleBeforeIsLeftOutWhereItIsSeenLonger) {
  Site site = diode_site();
  site.photodiodes.push_back(site.photodiodes.front());
  site.photodiodes[1].id = "up";
  site.photodiodes[1].position_m[0].mean = 8.0;
  Random random(1);
  PowerTrace trace = trace_of(kTypical, site, matching_diode(), random);
  Vehicle leader = kTypical;
  leader.speed_mps = 14.0;
  leader.along_m = 2.2 * leader.speed_mps;
  Diode bright = matching_diode();
  bright.gain_w *= 4.0;
  bright.ambient_w = bright.noise_w = 0.0;
  const PowerTrace of_leader = trace_of(leader, site, bright, random);
  for (std::size_t i = 0; i < trace.power_w.size(); ++i) trace.power_w[i] += of_leader.power_w[i];
  const PowerPass pass{.from_s = 1.8, .to_s = 2.9, .peak_s = 2.6, .photodiode = 1};
  const VehicleResult result = estimate_pass(pass, 1, site, {&trace, 1});
  for (const Method method : {Method::power_slope_photodiode, Method::ml_photodiode})
    EXPECT_NEAR(speed_of(method_of(result, method)), kTypical.speed_mps, 1.0) << name_of(method);
}

// Beside lamps that drive away only the peak is its own, where lamps are least alike.
TEST(Pass, WhoseLightIsItsOwnOnlyNearItsPeakHasNoSpeedByTheLaw) {
  const Site site = diode_site();
  Random random(1);
  const PowerTrace trace = trace_of(kTypical, site, matching_diode(), random);
  const double peak_w = *std::ranges::max_element(trace.power_w) - trace.ambient_w;
  const auto with_others = [&](double share) {
    PowerPass pass{-0.5, 2.5, 2.4};
    pass.others_w = share * peak_w;
    return estimate_pass(pass, 1, site, {&trace, 1});
  };
  for (const Method method : {Method::power_slope_photodiode, Method::ml_photodiode}) {
    EXPECT_NEAR(speed_of(method_of(with_others(0.003), method)), kTypical.speed_mps, 1.0)
        << name_of(method);
    EXPECT_EQ(std::get<Miss>(method_of(with_others(0.02), method).speed), Miss::several_vehicles)
        << name_of(method);
  }
}

TEST(Pass, WithoutAGainOtherVehiclesAreNotToBlame) {
  Site site = diode_site();
  site.channel->gain_db.reset();
  Random random(1);
  const PowerTrace trace = trace_of(kTypical, site, matching_diode(), random);
  PowerPass pass{-0.5, 2.5, 2.4};
  pass.others_w = 0.02 * *std::max_element(trace.power_w.begin(), trace.power_w.end());
  const VehicleResult result = estimate_pass(pass, 1, site, {&trace, 1});
  EXPECT_EQ(result.withheld, Miss::no_scale);
}

TEST(Pass, IsWithheldWhereTheLampsPulseFasterThanTheSamplesFollow) {
  const Site site = diode_site();
  Random random(1);
  PowerTrace trace = trace_of(kTypical, site, matching_diode(), random);
  constexpr double kPulses_hz = 437.0, kDuty = 0.5;
  for (std::size_t i = 0; i < trace.time_s.size(); ++i) {
    const double turns = kPulses_hz * trace.time_s[i];
    const double light_w = trace.power_w[i] - trace.ambient_w;
    const double lit = turns - std::floor(turns) < kDuty ? 1.0 / kDuty : 0.0;
    trace.power_w[i] = static_cast<float>(trace.ambient_w + lit * light_w);
  }
  const VehicleResult result = estimate_pass({-0.5, 2.5, 2.4}, 1, site, {&trace, 1});
  EXPECT_EQ(result.withheld, Miss::outside_model);
  ASSERT_EQ(result.warnings.size(), 1U);
  EXPECT_NE(result.warnings[0].find("pulse"), std::string::npos);
}

TEST(Pass, OnACurveUsesTheArcAngle) {
  Site site = diode_site();
  site.road.kind = RoadKind::curved;
  site.road.radius_m = Uncertain{44.0, 0.1};
  site.road.turn = Turn::left;
  site.photodiodes[0].position_m = {Uncertain{0.0, 0.0}, Uncertain{-4.0, 0.0},
                                    Uncertain{0.65, 0.0}};
  Vehicle vehicle = kTypical;
  vehicle.speed_mps = 15.0;
  vehicle.along_m = 48.0;
  Random random(1);
  const PowerTrace trace = trace_of(vehicle, site, matching_diode(), random);
  const VehicleResult result = estimate_pass({-0.5, 2.5, 2.4}, 1, site, {&trace, 1});
  ASSERT_FALSE(result.withheld) << name_of(*result.withheld);
  EXPECT_NEAR(speed_of(method_of(result, Method::curved_angle_photodiode)), 15.0, 0.02);
  EXPECT_NEAR(result.speed.speed_mps, 15.0, 0.02);
}

TEST(Pass, OnACurveTheLightTellsAnAmbientThatTheRecordDoesNot) {
  Site site = diode_site();
  site.road.kind = RoadKind::curved;
  site.road.radius_m = Uncertain{40.0, 0.0};
  site.road.turn = Turn::left;
  site.road.lanes[0].lateral_m = Uncertain{0.0, 0.0};
  site.photodiodes[0].position_m[2] = Uncertain{0.65, 0.0};
  Vehicle vehicle = kTypical;
  vehicle.lateral_m = 0.0;
  vehicle.along_m = 60.0;
  Random random(1);
  PowerTrace trace = trace_of(vehicle, site, matching_diode(), random);
  trace.ambient_w = trace.ambient_sigma_w = 0.5 * *std::ranges::min_element(trace.power_w);
  const VehicleResult result = estimate_pass({-0.5, 2.5, 2.4}, 1, site, {&trace, 1});
  ASSERT_FALSE(result.withheld) << name_of(*result.withheld);
  for (const Method method : {Method::curved_angle_photodiode, Method::ml_photodiode})
    EXPECT_NEAR(speed_of(method_of(result, method)), 20.0, 1.0) << name_of(method);
}

TEST(Pass, AmbientThatComesAndGoesBesideAVehicleGivesNoSpeed) {
  constexpr double kWidth_s = 0.7, kAt_s = 3.8;
  Site site = diode_site();
  site.channel->gain_db->std = 1.0;
  Vehicle far_off = kTypical;
  far_off.along_m = 120.0;
  Diode diode = matching_diode();
  diode.noise_w = 1e-10;
  diode.to_s = 7.0;
  int speeds = 0;  // of the power's slope, which asks no more of light than that it grows
  for (const double peak_w : {4e-8, 8e-8, 2e-7}) {
    Random random(1);
    PowerTrace trace = trace_of(far_off, site, diode, random);
    for (std::size_t i = 0; i < trace.time_s.size(); ++i)
      trace.power_w[i] += static_cast<float>(
          peak_w * std::exp(-0.5 * std::pow((trace.time_s[i] - kAt_s) / kWidth_s, 2)));
    const VehicleResult result = estimate_pass({2.2, 6.3, 6.0}, 1, site, {&trace, 1});
    ASSERT_TRUE(result.withheld) << peak_w << ": " << result.speed.speed_mps;
    // Lamps far unlike the law would explain the least of them.
    EXPECT_TRUE(*result.withheld == Miss::bad_fit || *result.withheld == Miss::too_uncertain)
        << peak_w << ": " << name_of(*result.withheld);
    speeds += std::holds_alternative<SpeedEstimate>(
        method_of(result, Method::power_slope_photodiode).speed);
  }
  EXPECT_GT(speeds, 0);
}

TEST(Pass, NothingAboveTheNoiseIsTooFewSamples) {
  const Site site = diode_site();
  Diode diode = matching_diode();
  diode.noise_w = 1.0;
  Random random(1);
  const PowerTrace trace = trace_of(kTypical, site, diode, random);
  EXPECT_EQ(estimate_pass({0.0, 2.5, 2.4}, 1, site, {&trace, 1}).withheld, Miss::too_few_samples);
  EXPECT_THROW(estimate_pass({0.0, 1.0, 0.5}, 1, site, {}), std::invalid_argument);
}

TEST(Joint, AgreesWithTheTruthWhateverTheBeam) {
  Site site = diode_site();
  site.channel->gain_db->std = 3.0;
  site.photodiodes[0].time_offset_s.std = 0.005;
  View view = kExactView;
  view.sigma_px = 0.2;
  for (const double cosine_exponent : {0.0, 3.0}) {
    Diode diode = matching_diode();
    diode.cosine_exponent = cosine_exponent;
    diode.noise_w = 1e-10;
    diode.time_offset_s = 0.003;
    Random random(3);
    const PowerTrace trace = trace_of(kTypical, site, diode, random);
    const VehicleResult camera = measured(site, view);
    const VehicleResult fused = measured(site, view, &trace);
    EXPECT_EQ(fused.method, Method::fused);
    EXPECT_GT(fused.n_pd_samples, 1000);
    EXPECT_LE(fused.speed.std_mps, 1.05 * camera.speed.std_mps);
    EXPECT_LE(std::abs(fused.speed.speed_mps - camera.speed.speed_mps), camera.speed.std_mps);
    EXPECT_LE(std::abs(fused.speed.speed_mps - 20.0), 3.0 * fused.speed.std_mps);
  }
}

TEST(Joint, DropsPowerThatIsNotThisVehicles) {
  const Site site = diode_site();
  Vehicle other = kTypical;
  other.along_m = 35.0;  // passes the photodiode while the camera still sees ours far off
  Random random(3);
  const PowerTrace trace = trace_of(other, site, matching_diode(), random);
  View view = kExactView;
  view.sigma_px = 0.2;
  const VehicleResult result = measured(site, view, &trace);
  EXPECT_EQ(result.method, Method::geometry_camera);
  EXPECT_FALSE(result.withheld);
  EXPECT_TRUE(std::holds_alternative<Miss>(method_of(result, Method::fused).speed));
  EXPECT_FALSE(result.warnings.empty());
}

// One sigma of the background moves the speed by what the background adds to the speed's sigma.
TEST(PhotodiodePower, AnErrorOfTheBackgroundIsInTheInterval) {
  constexpr double kCurvature = 0.2;  // of the speed in the background, and of its share
  const Site site = diode_site();
  const Diode diode = matching_diode();
  Random random(5);
  const PowerTrace exact = trace_of(kTypical, site, diode, random);
  const auto known = std::get<PowerCase>(
      photodiode_case(site, 0, {site.road.lanes[0].lateral_m, *site.lamps.height_m}));
  const double sigma_w = 0.1 * diode.gain_w * std::pow(40.0, -diode.path_loss_exponent);
  const auto speed_with = [&](double shift_w, double ambient_sigma_w) {
    PowerTrace trace = exact;
    trace.ambient_w += shift_w;
    PowerSeries series = vehicle_light(trace, site, known, 0.0, 2.0, nullptr).series;
    series.background_std_w = ambient_sigma_w;
    return std::get<PowerSpeed>(power_speed(series, known)).speed;
  };
  const double moved_mps =
      0.5 * (speed_with(sigma_w, 0.0).speed_mps - speed_with(-sigma_w, 0.0).speed_mps);
  const double known_mps = speed_with(0.0, 0.0).std_mps;
  const double unsure_mps = speed_with(0.0, sigma_w).std_mps;
  EXPECT_NEAR(std::sqrt(unsure_mps * unsure_mps - known_mps * known_mps) / std::abs(moved_mps), 1.0,
              kCurvature);
}

// As where the record shows no dark moment: the ambient may be anything below the least light.
TEST(PhotodiodePower, TellsAnAmbientThatTheRecordDoesNot) {
  const Site site = diode_site();
  const Diode diode = matching_diode();
  Random random(6);
  PowerTrace trace = trace_of(kTypical, site, diode, random);
  const double least_w = *std::ranges::min_element(trace.power_w);
  trace.ambient_w = trace.ambient_sigma_w = 0.5 * least_w;
  const auto known = std::get<PowerCase>(
      photodiode_case(site, 0, {site.road.lanes[0].lateral_m, *site.lamps.height_m}));
  const VehicleLight light = vehicle_light(trace, site, known, 0.0, 2.0, nullptr);
  EXPECT_EQ(light.series.background_std_w, trace.ambient_sigma_w) << "not told twice";
  EXPECT_LT(light.cleared.background_std_w, 0.2 * trace.ambient_sigma_w);
  const double taken_off_w =
      trace.ambient_w + light.series.power_w.front() - light.cleared.power_w.front();
  EXPECT_NEAR(taken_off_w, diode.ambient_w, 2.0 * light.cleared.background_std_w);
  const VehicleResult result = estimate_pass({-0.5, 2.5, 2.4}, 1, site, {&trace, 1});
  constexpr double kMost_mps = 1.0;  // 9 and 7 with the ambient in the middle of what it may be
  for (const Method method : {Method::power_slope_photodiode, Method::ml_photodiode})
    EXPECT_NEAR(speed_of(method_of(result, method)), kTypical.speed_mps, kMost_mps)
        << name_of(method);
}

}  // namespace
}  // namespace vildar
