#include <algorithm>
#include <cmath>

#include "core/quantity.h"
#include "estimate/recursive_fit.h"
#include "geometry_pass.h"
#include "support/trials.h"

namespace vildar {
namespace {

using simulated::expect_motion;
using simulated::kExact;
using simulated::kNoiseless;
using simulated::kTypical;
using simulated::mast_site;
using simulated::result_of;
using simulated::track_of;
using simulated::Vehicle;
using simulated::View;

TEST(Geometry, RecoversTheMotionWithoutNoise) {
  Site site = mast_site(4.0);
  site.camera->rolling_shutter_s = 0.02;
  site.camera->yaw_rad.mean = 0.05;
  site.camera->roll_rad.mean = -0.03;
  site.camera->distortion = DistortionModel::brown;
  site.camera->distortion_coefficients = {-0.2, 0.05, 1e-3, -1e-3, 0.0};
  const VehicleResult result = result_of(kTypical, site, kNoiseless);
  expect_motion(result, kTypical, kExact);
  EXPECT_NEAR(*result.range_ref_m / kTypical.along_at_m(result.speed.time_s), 1.0, kExact);
  EXPECT_NEAR(*result.lateral_m, -4.0, 4.0 * kExact);
  EXPECT_NEAR(*result.acceleration_mps2, 0.0, 1e-3);
  EXPECT_NEAR(*result.closing_speed_mps, result.speed.speed_mps, 1e-12);
  EXPECT_EQ(result.lane, "near");
}

TEST(Geometry, RecoversAcceleration) {
  // The prior N(0, 1.5 m/s^2) pulls by its share of the information, here a few per cent.
  constexpr double kPull_mps2 = 0.1;
  for (const double acceleration_mps2 : {-2.0, 2.0}) {
    Vehicle vehicle = kTypical;
    vehicle.acceleration_mps2 = acceleration_mps2;
    const VehicleResult result = result_of(vehicle, mast_site(4.0), kNoiseless);
    expect_motion(result, vehicle, 0.005);
    EXPECT_NEAR(*result.acceleration_mps2, acceleration_mps2, kPull_mps2);
  }
}

TEST(Geometry, SpeedScalesWithTheMetricPriors) {
  // The gauge: bearings alone cannot tell a scene from one `factor` times as large.
  constexpr double kFactor = 1.3;
  Site site = mast_site(4.0);
  Random random(1);
  const VehicleTrack track = track_of(kTypical, site, kNoiseless, random);
  const double speed_mps = estimate_vehicle(track, site, {}).result.speed.speed_mps;
  const auto stretch = [&](Uncertain& value) {
    value.mean *= kFactor;
    value.std *= kFactor;
  };
  const double height_m = site.lamps.height_m->mean;
  stretch(*site.lamps.height_m);
  site.lamps.height_m->mean = 4.0 - kFactor * (4.0 - height_m);
  stretch(*site.lamps.separation_m);
  stretch(site.road.lanes[0].lateral_m);
  const VehicleResult stretched = estimate_vehicle(track, site, {}).result;
  ASSERT_FALSE(stretched.withheld);
  EXPECT_NEAR(stretched.speed.speed_mps / speed_mps, kFactor, 1e-5);
}

// Of a level camera at a known height range goes as the focal length, and lengths across do not.
TEST(Geometry, AFocalLengthIsAsSureAsTheSiteSays) {
  constexpr double kShare = 0.02;
  Site site = mast_site(4.0);
  site.camera->pitch_rad.mean = 0.0;
  site.lamps.height_m->std = 0.001;
  const VehicleResult known = result_of(kTypical, site, {});
  site.camera->focal_std_px = kShare * 1400.0;
  const VehicleResult unsure = result_of(kTypical, site, {});
  ASSERT_FALSE(known.withheld);
  ASSERT_FALSE(unsure.withheld);
  const auto relative = [](const VehicleResult& result) {
    return result.speed.std_mps / result.speed.speed_mps;
  };
  EXPECT_NEAR(relative(unsure), std::hypot(relative(known), kShare), 5e-4);
}

TEST(Geometry, IntervalsHoldWhereTheFocalLengthIsUnsure) {
  constexpr int kTrials = 400, kLeast = 367, kMost = 393,
                kMostWithheld = 4;  // 95 % less or more three sigmas
  constexpr double kShare = 0.02;
  Random random(23);
  int inside = 0, withheld = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    Site site = mast_site(4.0);
    site.camera->focal_std_px = kShare * 1400.0;
    Site truth = site;
    for (double& focal_px : truth.camera->focal_px) focal_px *= 1.0 + kShare * random.normal();
    const Vehicle vehicle{.speed_mps = random.uniform(12.0, 25.0),
                          .acceleration_mps2 = random.normal(0.0, 0.5),
                          .lateral_m = random.normal(-4.0, 0.3),
                          .height_m = random.normal(0.65, 0.1),
                          .separation_m = random.normal(1.2, 0.15)};
    const VehicleTrack track = track_of(vehicle, truth, {}, random);
    const VehicleResult result = estimate_vehicle(track, site, {}).result;
    if (result.withheld) {  // what lies far from all that is known
      ++withheld;
      continue;
    }
    const double true_mps = vehicle.speed_at_mps(result.speed.time_s);
    inside += result.speed.lo95_mps < true_mps && true_mps < result.speed.hi95_mps;
  }
  EXPECT_LE(withheld, kMostWithheld);
  EXPECT_GE(inside, kLeast);
  EXPECT_LE(inside, kMost);
}

TEST(Geometry, WorksInALaneRightAheadOfTheCamera) {
  Site site = mast_site(4.0);
  site.road.lanes[0].lateral_m = {0.0, 0.3};
  Vehicle vehicle = kTypical;
  vehicle.lateral_m = 0.0;
  expect_motion(result_of(vehicle, site, kNoiseless), vehicle, kExact);
}

TEST(Geometry, WorksOnCurves) {
  for (const Turn turn : {Turn::left, Turn::right}) {
    Site site = mast_site(4.0);
    site.road.kind = RoadKind::curved;
    site.road.radius_m = Uncertain{60.0, 0.0};
    site.road.straight_m.mean = 10.0;
    site.road.turn = turn;
    site.camera->yaw_rad.mean = turn == Turn::left ? 0.3 : -0.3;
    Vehicle vehicle = kTypical;
    vehicle.speed_mps = 12.0;
    View view = kNoiseless;
    view.to_s = 3.0;
    const VehicleResult result = result_of(vehicle, site, view);
    expect_motion(result, vehicle, kExact);
    const auto place = simulated::lamps_at(vehicle, site.road, result.speed.time_s).middle_m;
    EXPECT_NEAR(*result.range_ref_m, place.x(), 1e-4);
    EXPECT_NEAR(*result.lateral_m, place.y(), 1e-4);
  }
}

Site before_a_bend(Uncertain straight_m) {
  Site site = mast_site(6.0);
  site.road.kind = RoadKind::curved;
  site.road.radius_m = Uncertain{120.0, 0.0};
  site.road.turn = Turn::left;
  site.road.straight_m = straight_m;
  site.camera->yaw_rad.mean = 0.1;
  return site;
}

// Taken as told, 3 m of 30 are 10 % of speed with a sigma of a tenth of a percent.
TEST(Geometry, WhereABendBeginsIsNotKnownToTheMillimetre) {
  constexpr int kTrials = 60, kLeastInside = 54;
  const Site told = before_a_bend({30.0, 0.0});
  Random random(9);
  int inside = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const double straight_m = random.normal(30.0, 3.0);
    const Site truth = before_a_bend({straight_m, 0.0});
    Vehicle vehicle = kTypical;
    vehicle.speed_mps = random.uniform(8.0, 20.0);
    vehicle.along_m = straight_m + 30.0;
    const View view{.to_s = 3.0, .sigma_px = 0.1};
    const VehicleResult result =
        estimate_vehicle(track_of(vehicle, truth, view, random), told, {}).result;
    ASSERT_FALSE(result.withheld) << name_of(*result.withheld);
    const double off_mps = std::abs(result.speed.speed_mps - vehicle.speed_mps);
    EXPECT_LT(off_mps, 3.5 * result.speed.std_mps) << straight_m;
    inside +=
        result.speed.lo95_mps <= vehicle.speed_mps && vehicle.speed_mps <= result.speed.hi95_mps;
  }
  EXPECT_GE(inside, kLeastInside);
}

TEST(Geometry, ASurveyedBeginOfABendSetsTheScale) {
  Site site = before_a_bend({30.0, 0.0});
  site.lamps.height_m = {0.65, 0.3};
  site.road.radius_m->std = 12.0;
  const double plain_mps = result_of(kTypical, site, kNoiseless).speed.std_mps;
  site.road.straight_m.std = 0.05;
  EXPECT_LT(result_of(kTypical, site, kNoiseless).speed.std_mps, 0.25 * plain_mps);
}

// To and fro by 8 cm about the lane's middle, which over three seconds is another curve than the
// road's: taken as known, that would be wrong by three standard deviations. The same of the filter.
TEST(Geometry, OnABendAWeaveIsNotTakenForItsRadius) {
  constexpr int kTrials = trials(80);
  const Site site = before_a_bend({0.0, 0.0});
  Random random(12);
  int measured = 0;
  double squares = 0.0, filtered_squares = 0.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    Vehicle vehicle = kTypical;
    vehicle.speed_mps = random.uniform(8.0, 20.0);
    vehicle.along_m = 3.0 * vehicle.speed_mps + 12.0;
    vehicle.height_m = random.normal(site.lamps.height_m->mean, site.lamps.height_m->std);
    vehicle.separation_m =
        random.normal(site.lamps.separation_m->mean, site.lamps.separation_m->std);
    vehicle.weave = {0.08, random.uniform(6.0, 10.0), random.uniform(0.0, 2.0 * kPi)};
    const View view{.to_s = 3.0, .sigma_px = 0.1};
    const VehicleTrack track = track_of(vehicle, site, view, random);
    RecursiveFit filter(site, track);
    for (const VehicleSighting& sighting : track.sightings) filter.add(sighting);
    const auto filtered = filter.speed();
    const VehicleResult result = estimate_vehicle(track, site, {}).result;
    const auto* last = std::get_if<SpeedEstimate>(&filtered);
    if (result.withheld || !last) continue;
    ++measured;
    const auto sigmas = [&](const SpeedEstimate& speed) {
      return (speed.speed_mps - vehicle.speed_mps) / speed.std_mps;
    };
    squares += std::pow(sigmas(result.speed), 2);
    filtered_squares += std::pow(sigmas(*last), 2);
  }
  ASSERT_GE(measured, 0.9 * kTrials);
  EXPECT_LT(std::sqrt(squares / measured), 1.3);
  EXPECT_LT(std::sqrt(filtered_squares / measured), 1.3);
}

// In a roundabout the outer lamp of a car goes 4 % faster than its middle, and a lone one may be
// it.
TEST(Geometry, OneLampOnATightBendMayBeTheOuterOne) {
  Site site = mast_site(4.0);
  site.road.kind = RoadKind::curved;
  site.road.radius_m = Uncertain{20.0, 0.0};
  site.road.straight_m.mean = 0.0;
  site.road.turn = Turn::right;
  site.camera->yaw_rad.mean = -0.3;
  const Vehicle car{6.0, 0.0, 18.0, -4.0, 0.65, 1.2};
  View view = kNoiseless;
  view.to_s = 1.5;
  const VehicleResult pair = result_of(car, site, view);
  view.single_lamp = true;
  const VehicleResult lone = result_of(car, site, view);
  ASSERT_FALSE(pair.withheld || lone.withheld);
  const double off = 0.5 * site.lamps.separation_m->mean / (20.0 - 4.0);
  EXPECT_LT(pair.speed.std_mps, 0.5 * off * pair.speed.speed_mps);
  EXPECT_GT(lone.speed.std_mps, off * lone.speed.speed_mps);
  EXPECT_LT(lone.speed.std_mps, 1.5 * off * lone.speed.speed_mps);
}

TEST(Geometry, OneLampIsEnough) {
  View view = kNoiseless;
  view.single_lamp = true;
  expect_motion(result_of(kTypical, mast_site(4.0), view), kTypical, kExact);
}

TEST(Geometry, RecedingVehicles) {
  Site site = mast_site(4.0);
  site.road.lanes.push_back({"far", {-7.5, 0.3}, 3.5, Direction::receding});
  const Vehicle vehicle{-15.0, 0.0, 15.0, -7.5, 0.65, 1.2};
  Random random(1);
  VehicleTrack track = track_of(vehicle, site, kNoiseless, random);
  track.direction = Direction::receding;
  track.kind = LampKind::taillamp;
  const VehicleResult result = estimate_vehicle(track, site, {}).result;
  expect_motion(result, vehicle, kExact);
  EXPECT_EQ(result.lane, "far");
  EXPECT_NEAR(*result.closing_speed_mps, -15.0, 1e-3);
  ASSERT_EQ(result.warnings.size(), 1U);
  EXPECT_EQ(result.methods.size(), 1U);  // headlamp light only

  track.direction = Direction::oncoming;
  EXPECT_EQ(estimate_vehicle(track, site, {}).result.withheld, Miss::direction_contradicts);
}

TEST(Geometry, PicksTheLaneByTheBearings) {
  Site site = mast_site(4.0);
  site.road.lanes.push_back({"next", {-7.5, 0.0}, 3.5, Direction::oncoming});
  for (const auto& [lateral_m, lane] : {std::pair{-4.0, "near"}, {-7.5, "next"}}) {
    Vehicle vehicle = kTypical;
    vehicle.lateral_m = lateral_m;
    const VehicleResult result = result_of(vehicle, site, kNoiseless);
    expect_motion(result, vehicle, kExact);
    EXPECT_EQ(result.lane, lane);
  }
  Vehicle between = kTypical;
  between.lateral_m = -5.75;
  const VehicleResult result = result_of(between, site, kNoiseless);
  expect_motion(result, between, kExact);
  EXPECT_EQ(result.lane, "");
}

// Letters in the picture and street lamps do as much as a parked car.
TEST(Geometry, LightsThatStandAllTheTimeHaveNoSpeed) {
  Vehicle vehicle = kTypical;
  vehicle.along_m = 30.0;
  View view = kNoiseless;
  view.sigma_px = 0.2;
  const auto result_at = [&](double speed_mps) {
    vehicle.speed_mps = speed_mps;
    return result_of(vehicle, mast_site(4.0), view);
  };
  const VehicleResult stands = result_at(0.0);
  EXPECT_EQ(stands.withheld, Miss::not_on_road);
  ASSERT_FALSE(stands.warnings.empty());
  EXPECT_NE(stands.warnings.back().find("stands all the time"), std::string::npos);
  const VehicleResult creeps = result_at(1.0);
  ASSERT_FALSE(creeps.withheld);
  EXPECT_NEAR(creeps.speed.speed_mps, 1.0, 3.0 * creeps.speed.std_mps);
}

TEST(Geometry, RowsFollowTheVehicle) {
  const Site site = mast_site(4.0);
  Random random(1);
  const VehicleTrack track = track_of(kTypical, site, kNoiseless, random);
  const VehicleEstimate estimate = estimate_vehicle(track, site, {});
  ASSERT_EQ(estimate.rows.size(), track.sightings.size());
  for (const TrackRow& row : estimate.rows) {
    const double range_m = kTypical.along_at_m(row.time_s);
    ASSERT_TRUE(row.range_m && row.speed_mps && row.bearing_rad);
    EXPECT_NEAR(*row.range_m / range_m, 1.0, 1e-5);
    EXPECT_NEAR(*row.speed_mps, 20.0, 1e-3);
    EXPECT_NEAR(row.bearing_rad->x(), std::atan2(-4.0, range_m), 1e-6);
    EXPECT_NEAR(row.bearing_rad->y(), std::atan2(0.65 - 4.0, std::hypot(range_m, 4.0)), 1e-6);
    EXPECT_GT(row.bearing_left_rad->x(), row.bearing_right_rad->x());
  }
}

TEST(Geometry, AWideYawPriorIsTurnedToTheTruth) {
  // Twice the prior's own sigma off: the vanishing point of the motion tells the yaw.
  Site site = mast_site(4.0);
  site.camera->yaw_rad.std = radians_from_degrees(3.0);
  Site truth = site;
  truth.camera->yaw_rad.mean = radians_from_degrees(6.0);
  View view = kNoiseless;
  view.sigma_px = 0.1;
  Random random(1);
  const VehicleTrack track = track_of(kTypical, truth, view, random);
  const VehicleEstimate estimate = estimate_vehicle(track, site, {});
  // Sigma of speed is 2.7 %, all of it from the priors, whose means are the truth.
  expect_motion(estimate.result, kTypical, 0.01);
  constexpr double kBearing_rad = 2e-3;  // a few sigmas of the yaw that the fit finds
  for (const TrackRow& row : estimate.rows)
    EXPECT_NEAR(row.bearing_rad->x(), std::atan2(-4.0, kTypical.along_at_m(row.time_s)),
                kBearing_rad);
}

TEST(Geometry, AFitBeginsWhereTheWayInThePictureIsLevel) {
  // From a bridge that looks down by more than the site file's two sigmas: vehicles of its lanes,
  // up to some metres before it.
  for (const double off_deg : {8.0, 10.0, 12.0})
    for (const double speed_mps : {25.0, 27.0, 29.0}) {
      const Vehicle vehicle{speed_mps, 0.0, 6.0 + 2.65 * speed_mps, 0.0, 0.65, 1.2};
      Site site = mast_site(7.0);
      site.camera->focal_std_px = 0.015 * site.camera->focal_px[0];
      site.camera->yaw_rad.std = radians_from_degrees(5.0);
      site.camera->pitch_rad = {radians_from_degrees(-9.0), radians_from_degrees(4.0)};
      Site truth = site;
      truth.camera->pitch_rad.mean -= radians_from_degrees(off_deg);
      Random random(1);
      const VehicleTrack track =
          track_of(vehicle, truth, {.to_s = 2.65, .frame_rate_hz = 30.0, .sigma_px = 0.1}, random);
      const VehicleResult result = estimate_vehicle(track, site, {}).result;
      SCOPED_TRACE(testing::Message() << off_deg << " degrees, " << speed_mps << " m/s");
      expect_motion(result, vehicle, 0.03);  // 1.8 % by the lengths, of which the turn takes some
    }
}

TEST(Geometry, SaysWhyThereIsNoSpeed) {
  const auto reason = [](const Vehicle& vehicle, const Site& site, const View& view) {
    const VehicleResult result = result_of(vehicle, site, view);
    if (result.withheld) {
      EXPECT_EQ(std::get<Miss>(result.methods.front().speed), *result.withheld);
    }
    return result.withheld;
  };
  const auto until = [](double to_s) {
    View view = kNoiseless;
    view.to_s = to_s;
    return view;
  };
  View short_view = until(0.2);
  EXPECT_EQ(reason(kTypical, mast_site(4.0), short_view), Miss::too_few_samples);
  short_view.frame_rate_hz = 100.0;
  short_view.to_s = 0.1;
  EXPECT_EQ(reason(kTypical, mast_site(4.0), short_view), Miss::too_short);

  Site no_scale = mast_site(4.0);
  no_scale.lamps = {};
  EXPECT_FALSE(reason(kTypical, no_scale, kNoiseless));  // its one lane is a scale
  no_scale.road.lanes.push_back({"next", {-7.5, 0.0}, 3.5, Direction::oncoming});
  EXPECT_EQ(reason(kTypical, no_scale, kNoiseless), Miss::no_scale);

  Vehicle lifted = kTypical, beside = kTypical;
  lifted.height_m = 3.0;
  EXPECT_EQ(reason(lifted, mast_site(4.0), kNoiseless), Miss::not_on_road);
  beside.lateral_m = -14.0;
  EXPECT_EQ(reason(beside, mast_site(4.0), kNoiseless), Miss::not_on_road);

  Vehicle braking = kTypical, thrown = kTypical;
  braking.acceleration_mps2 = -7.0;
  EXPECT_FALSE(reason(braking, mast_site(4.0), kNoiseless));
  thrown.acceleration_mps2 = -15.0;
  EXPECT_EQ(reason(thrown, mast_site(4.0), until(1.2)), Miss::bad_fit);
  thrown.acceleration_mps2 = 15.0;
  EXPECT_EQ(reason(thrown, mast_site(4.0), until(1.2)), Miss::bad_fit);

  Site vague = mast_site(4.0);
  vague.road.lanes.clear();
  vague.lamps.separation_m.reset();
  vague.lamps.height_m = Uncertain{0.65, 2.0};
  EXPECT_EQ(reason(kTypical, vague, kNoiseless), Miss::too_uncertain);
}

// Over the camera, where the site has lamps below it: the shorter all lengths, the less they deny.
TEST(Geometry, LampsThatNoKnownLengthsExplainFitBadly) {
  Vehicle high = kTypical;
  high.height_m = 7.0;
  Random random(3);
  const Site site = mast_site(4.0);
  EXPECT_EQ(estimate_vehicle(track_of(high, site, kNoiseless, random), site, {}).result.withheld,
            Miss::bad_fit);
}

TEST(Geometry, DoubtsOfTheTrackAreKept) {
  const Site site = mast_site(4.0);
  Random random(1);
  VehicleTrack track = track_of(kTypical, site, kNoiseless, random);
  track.ambiguous_identity = true;
  EXPECT_EQ(estimate_vehicle(track, site, {}).result.withheld, Miss::ambiguous_identity);
  track.ambiguous_identity = false;
  track.direction_contradicts = true;
  const VehicleEstimate estimate = estimate_vehicle(track, site, {});
  EXPECT_EQ(estimate.result.withheld, Miss::direction_contradicts);
  EXPECT_FALSE(estimate.rows.front().range_m);
  track.direction_contradicts = false;
  track.beside_lanes_m = -7.2;
  const VehicleResult beside = estimate_vehicle(track, site, {}).result;
  EXPECT_EQ(beside.withheld, Miss::not_on_road);
  ASSERT_EQ(beside.warnings.size(), 1U);
  EXPECT_NE(beside.warnings[0].find("y = -7.2 m"), std::string::npos) << beside.warnings[0];
}

// It stands 20 m off for two seconds, where its speed, nought, is known best of all.
TEST(Geometry, AVehicleThatStopsHasASpeedOfWhenItDrove) {
  Vehicle stops = kTypical;
  stops.speed_mps = 12.0;
  stops.along_m = 44.0;
  stops.acceleration_mps2 = -3.0;
  stops.changes = {{4.0, 3.0}};
  View view{.to_s = 6.0};
  Random random(2);
  const auto result =
      estimate_vehicle(track_of(stops, mast_site(4.0), view, random), mast_site(4.0), {}).result;
  ASSERT_FALSE(result.withheld) << name_of(*result.withheld);
  const double truth_mps = stops.speed_at_mps(result.speed.time_s);
  EXPECT_GT(truth_mps, 3.0);
  EXPECT_NEAR(result.speed.speed_mps, truth_mps, 3.0 * result.speed.std_mps);
}

TEST(Geometry, JumpingCentroidsAreNoFit) {
  View view = kNoiseless;
  view.shake_px = 30.0;
  EXPECT_EQ(result_of(kTypical, mast_site(4.0), view).withheld, Miss::bad_fit);
}

}  // namespace
}  // namespace vildar
