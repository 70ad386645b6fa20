#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>

#include "geometry_pass.h"
#include "support/trials.h"

namespace vildar {
namespace {

using simulated::expect_motion;
using simulated::kNoiseless;
using simulated::mast_site;
using simulated::result_of;
using simulated::track_of;
using simulated::Vehicle;
using simulated::View;

Site dashcam_site() {
  Site site = mast_site(1.3);
  site.camera->pitch_rad = {0.0, 0.003};
  site.road.lanes = {{"other", {3.5, 0.3}, 3.5, Direction::oncoming},
                     {"own", {0.0, 0.3}, 3.5, Direction::receding}};
  site.ego = EgoSite{{15.0, 0.3}, {}, {}};
  return site;
}

TEST(Geometry, DashcamSpeedIsOverTheGround) {
  const Vehicle vehicle{12.0, 0.0, 80.0, 3.5, 0.65, 1.2};
  View view = kNoiseless;
  view.ego_mps = 15.0;
  const VehicleResult result = result_of(vehicle, dashcam_site(), view);
  expect_motion(result, vehicle, 1e-4);
  EXPECT_NEAR(*result.closing_speed_mps, 27.0, 1e-3);
  EXPECT_GE(result.speed.std_mps, 0.3);  // that of the own speed is part of it
}

TEST(Geometry, DashcamFollowsAnEgoTrace) {
  const Vehicle vehicle{12.0, 0.0, 80.0, 3.5, 0.65, 1.2};
  View view = kNoiseless;
  view.ego_mps = 15.0;
  view.ego_acceleration_mps2 = -3.0;
  Site site = dashcam_site();
  for (double t_s = -1.0; t_s < 5.0; t_s += 0.1)
    site.ego->trace.push_back({t_s, 15.0 - 3.0 * t_s, 0.0});
  // The nose dives.
  Site diving = site;
  diving.camera->pitch_rad.mean -= radians_from_degrees(0.15 * 3.0);
  Random random(1);
  const VehicleResult result =
      estimate_vehicle(track_of(vehicle, diving, view, random), site, {}).result;
  expect_motion(result, vehicle, 1e-3);
  EXPECT_NEAR(*result.closing_speed_mps, 12.0 + 15.0 - 3.0 * result.speed.time_s, 0.02);
}

// Beyond the end of its trace the own car brakes: what was seen there says nothing of the other.
TEST(Geometry, WhereATraceDoesNotTellTheOwnSpeedNothingIsMeasured) {
  const Vehicle vehicle{12.0, 0.0, 80.0, 3.5, 0.65, 1.2};
  View view = kNoiseless;
  view.ego_mps = 15.0;
  view.ego_acceleration_mps2 = -3.0;
  for (const double end_s : {1.2, -0.5}) {
    Site site = dashcam_site();
    for (double t_s = -1.0; t_s < end_s; t_s += 0.1)
      site.ego->trace.push_back({t_s, 15.0 - 3.0 * t_s, 0.0});
    Random random(1);
    const VehicleResult result =
        estimate_vehicle(track_of(vehicle, site, view, random), site, {}).result;
    ASSERT_EQ(result.warnings.size(), 1U);
    if (end_s > 0.0) {
      ASSERT_FALSE(result.withheld);
      EXPECT_NEAR(result.speed.speed_mps, 12.0, result.speed.std_mps);
      EXPECT_NE(result.warnings[0].find("measured from 0.00 to 1."), std::string::npos);
    } else {
      EXPECT_EQ(result.withheld, Miss::too_few_samples);
      EXPECT_NE(result.warnings[0].find("does not tell the own speed"), std::string::npos);
    }
  }
}

// Coding lets the lamps of a car ahead seem to creep apart and together again, by a few tenths of a
// pixel: its speed is the own one but for the little by which the gap grows.
TEST(Geometry, ACarAheadWhoseLampsCreepHasASpeedWithASigmaThatSaysSo) {
  Site site = dashcam_site();
  site.ego = EgoSite{{20.0, 0.0}, {}, {}};
  View view;
  view.ego_mps = 20.0;
  view.sigma_px = 0.05;
  view.to_s = 4.5;
  const Vehicle ahead{-21.0, 0.0, 24.0, 0.0, 0.85, 1.2};
  for (const double creep_px : {0.0, 0.15, 0.3}) {
    Random random(3);
    VehicleTrack track = track_of(ahead, site, view, random);
    track.kind = LampKind::taillamp;
    track.direction = Direction::receding;
    for (VehicleSighting& sighting : track.sightings) {
      const double off_px = creep_px * std::sin(2.0 * kPi * seconds_of(sighting.time) / 3.5);
      sighting.left->centre_px.x() -= off_px;
      sighting.right->centre_px.x() += off_px;
    }
    const VehicleResult result = estimate_vehicle(track, site, {}).result;
    ASSERT_FALSE(result.withheld) << creep_px << " px: " << name_of(*result.withheld);
    EXPECT_LT(std::abs(result.speed.speed_mps - 21.0), 2.5 * result.speed.std_mps) << creep_px;
    EXPECT_LT(result.speed.std_mps, 1.0);
    // The scale, known to a tenth, is that of the closing speed alone.
    ASSERT_TRUE(result.budget && result.closing_speed_mps);
    EXPECT_LT(result.budget->scale * result.speed.speed_mps,
              0.2 * std::abs(*result.closing_speed_mps));
    EXPECT_GT(result.budget->shape, 0.0);
  }
}

constexpr double kOwnSpeed_mps = 18.0;
using Heading = std::function<double(double time_s)>;

/// Where one at that speed comes who heads so off the road from `left_m` of its line: x, y,
/// heading.
Eigen::Vector3d driven(const Heading& heading_rad, double left_m, double time_s) {
  constexpr double kStep_s = 1e-3;
  Eigen::Vector3d at(0.0, left_m, heading_rad(time_s));
  for (double t_s = 0.5 * kStep_s; t_s < time_s; t_s += kStep_s)
    at.head<2>() += kOwnSpeed_mps * kStep_s *
                    Eigen::Vector2d(std::cos(heading_rad(t_s)), std::sin(heading_rad(t_s)));
  return at;
}

/// How vehicles with lamps and places drawn from the site's priors are measured from a dashcam.
class DashcamPasses {
 public:
  void add(Random& random, const Heading& heading_rad, double left_m, std::optional<EgoSite> told) {
    Site site = dashcam_site();
    site.ego = std::move(told);
    simulated::Vehicle vehicle;
    vehicle.speed_mps = random.uniform(10.0, 30.0);
    vehicle.height_m = 0.65 + 0.1 * random.normal();
    vehicle.separation_m = 1.2 + 0.15 * random.normal();
    vehicle.lateral_m = 3.5 + 0.3 * random.normal();
    const double meet_s = random.uniform(4.5, 6.5);
    vehicle.along_m = meet_s * (vehicle.speed_mps + kOwnSpeed_mps);
    simulated::View view;
    view.from_s = meet_s - 2.5;
    view.to_s = meet_s - 0.3;
    const std::function<Eigen::Vector3d(double)> pose = [&](double time_s) {
      return driven(heading_rad, left_m, time_s);
    };
    view.ego_pose = &pose;
    const auto result =
        estimate_vehicle(simulated::track_of(vehicle, site, view, random), site, {}).result;
    ++passes_;
    if (result.withheld) return;
    ++measured_;
    inside_ +=
        result.speed.lo95_mps <= vehicle.speed_mps && vehicle.speed_mps <= result.speed.hi95_mps;
    EXPECT_LT(std::abs(result.speed.speed_mps - vehicle.speed_mps), 4.0 * result.speed.std_mps)
        << passes_ - 1 << ": " << result.speed.speed_mps << " +- " << result.speed.std_mps
        << " for " << vehicle.speed_mps;
  }
  double measured_share() const { return static_cast<double>(measured_) / passes_; }
  double inside_share() const { return static_cast<double>(inside_) / measured_; }

 private:
  int passes_ = 0, measured_ = 0, inside_ = 0;
};

// Changes lanes and back: yaw rate A sin(2 pi phase), the heading is its integral.
TEST(Geometry, ADashcamThatSwervesKeepsItsIntervals) {
  DashcamPasses passes;
  for (int i = 0; i < 60; ++i) {
    Random random(static_cast<std::uint64_t>(20261125 + i));
    const double begin_s = random.uniform(3.0, 5.0), length_s = random.uniform(2.0, 3.0);
    const double rate_rad_per_s = random.uniform(0.03, 0.09) * (i % 2 == 0 ? 1.0 : -1.0);
    const Heading heading_rad = [=](double time_s) {
      const double phase = std::clamp((time_s - begin_s) / length_s, 0.0, 1.0);
      return rate_rad_per_s * length_s / (2.0 * kPi) * (1.0 - std::cos(2.0 * kPi * phase));
    };
    EgoSite told{{kOwnSpeed_mps, 0.0}, {}, {}};
    const double late_s = random.uniform(-0.1, 0.1), turns = 1.0 + 0.02 * random.normal();
    for (int k = -50; k <= 900; ++k) {
      const double time_s = 0.01 * k;
      told.trace.push_back(
          {time_s + late_s, kOwnSpeed_mps,
           turns * (heading_rad(time_s + 1e-4) - heading_rad(time_s - 1e-4)) / 2e-4});
    }
    passes.add(random, heading_rad, 0.0, told);
  }
  EXPECT_GE(passes.measured_share(), 0.5);
  EXPECT_GE(passes.inside_share(), 0.88);
}

// Half a degree to and fro, every 5 to 12 s.
struct Wander {
  Heading heading_rad, left_m;  // about the middle of its lane
};

Wander wander(Random& random) {
  const double kWave_rad = 0.008 / std::sqrt(1.5);
  struct Wave {
    double rate_rad_per_s, phase_rad;
  };
  std::array<Wave, 3> waves;
  for (auto& [rate_rad_per_s, phase_rad] : waves) {
    rate_rad_per_s = 2.0 * kPi / random.uniform(5.0, 12.0);
    phase_rad = random.uniform(0.0, 2.0 * kPi);
  }
  Wander found;
  found.heading_rad = [=](double time_s) {
    double sum = 0.0;
    for (const auto& [rate_rad_per_s, phase_rad] : waves)
      sum += std::sin(rate_rad_per_s * time_s + phase_rad);
    return kWave_rad * sum;
  };
  found.left_m = [=](double time_s) {
    double sum = 0.0;
    for (const auto& [rate_rad_per_s, phase_rad] : waves)
      sum -= std::cos(rate_rad_per_s * time_s + phase_rad) / rate_rad_per_s;
    return kWave_rad * kOwnSpeed_mps * sum;
  };
  return found;
}

// Of which the site says nothing.
TEST(Geometry, ADashcamThatWandersUntoldKeepsItsIntervals) {
  DashcamPasses passes;
  for (int i = 0; i < 100; ++i) {
    Random random(static_cast<std::uint64_t>(20261225 + i));
    const auto [heading_rad, left_m] = wander(random);
    passes.add(random, heading_rad, left_m(0.0), EgoSite{{kOwnSpeed_mps, 0.0}, {}, {}});
  }
  EXPECT_GE(passes.measured_share(), 0.9);
  EXPECT_GE(passes.inside_share(), 0.9);
}

struct CarsAhead {
  int measured = 0, inside = 0;
  double sigma_mps = 0.0;  // mean
};

constexpr int kCarsAhead = trials(30);

// Cars ahead of a dashcam that wanders untold, and pitches.
CarsAhead cars_ahead(double seen_s, double pitching_px) {
  constexpr double kPitching_hz = 1.4;
  CarsAhead found;
  for (int i = 0; i < kCarsAhead; ++i) {
    Random random(static_cast<std::uint64_t>(20261126 + i));
    const auto [heading_rad, left_m] = wander(random);
    Site site = dashcam_site();
    site.ego = EgoSite{{kOwnSpeed_mps, 0.0}, {}, {}};
    const double speed_mps = kOwnSpeed_mps + random.uniform(-0.6, 1.5);
    const Vehicle ahead{-speed_mps,
                        0.0,
                        random.uniform(22.0, 35.0),
                        0.3 * random.normal(),
                        0.65 + 0.1 * random.normal(),
                        1.2 + 0.15 * random.normal()};
    View view;
    view.sigma_px = 0.05;
    view.to_s = seen_s;
    const std::function<Eigen::Vector3d(double)> pose = [&](double time_s) {
      return Eigen::Vector3d(kOwnSpeed_mps * time_s, left_m(time_s), heading_rad(time_s));
    };
    view.ego_pose = &pose;
    VehicleTrack track = track_of(ahead, site, view, random);
    track.kind = LampKind::taillamp;
    track.direction = Direction::receding;
    const double phase_rad = random.uniform(0.0, 2.0 * kPi);
    for (VehicleSighting& sighting : track.sightings)
      for (auto* lamp : {&sighting.left, &sighting.right})
        if (*lamp)
          (*lamp)->centre_px.y() +=
              pitching_px *
              std::sin(2.0 * kPi * kPitching_hz * seconds_of(sighting.time) + phase_rad);
    const VehicleResult result = estimate_vehicle(track, site, {}).result;
    if (result.withheld) continue;
    const SpeedEstimate& speed = result.speed;
    ++found.measured;
    found.inside += speed.lo95_mps <= speed_mps && speed_mps <= speed.hi95_mps;
    found.sigma_mps += speed.std_mps / kCarsAhead;
  }
  return found;
}

TEST(Geometry, ACarAheadIsMeasuredHoweverOneWanders) {
  for (const double seen_s : {4.5, 15.0}) {
    const CarsAhead cars = cars_ahead(seen_s, 0.0);
    EXPECT_GE(cars.measured, kCarsAhead - 2) << seen_s << " s";
    EXPECT_GE(cars.inside, 0.9 * cars.measured) << seen_s << " s";
    EXPECT_LT(cars.sigma_mps, 0.3) << seen_s << " s";
  }
}

// By half a degree: the elevations tell little then, the separation of the lamps what it can.
TEST(Geometry, ADashcamThatPitchesHardMeasuresWithWideIntervals) {
  const CarsAhead cars = cars_ahead(4.5, 7.0);
  EXPECT_GE(cars.measured, kCarsAhead - 2);
  EXPECT_GE(cars.inside, 0.9 * cars.measured);
}

// At a crossing one ahead may turn before the own vehicle does; on a bend it keeps to the road.
TEST(Geometry, BeforeOneTurnsOffACarAheadHasNoSpeed) {
  constexpr double kOwn_mps = 6.0, kFrom_s = 3.0, kTo_s = 5.0;
  for (const auto& [yaw_rate, withheld] : {std::pair(0.3, true), std::pair(0.1, false)}) {
    Site site = dashcam_site();
    site.ego = EgoSite{{kOwn_mps, 0.1}, {}, {}};
    for (double t_s = -0.5; t_s < 6.5; t_s += 0.1)
      site.ego->trace.push_back({t_s, kOwn_mps, t_s > kFrom_s && t_s < kTo_s ? yaw_rate : 1e-6});
    View view;
    view.to_s = 2.5;
    view.ego_mps = kOwn_mps;
    Random random(8);
    VehicleTrack track = track_of({-7.0, 0.0, 20.0, 0.0, 0.65, 1.2}, site, view, random);
    track.kind = LampKind::taillamp;
    track.direction = Direction::receding;
    EXPECT_EQ(estimate_vehicle(track, site, {}).result.withheld,
              withheld ? std::optional(Miss::not_on_road) : std::nullopt)
        << yaw_rate;
  }
}

// The 6 s in which it is nearest: the last ones of one that is caught up with, by its lamps'
// separation, or of a lone lamp by its light.
TEST(Geometry, OfALongTrackTheNearestPartIsMeasured) {
  constexpr double kSeen_s = 15.0;
  Site site = dashcam_site();
  site.ego = EgoSite{{kOwnSpeed_mps, 0.0}, {}, {}};
  for (const bool single_lamp : {false, true}) {
    Random random(11);
    View view;
    view.ego_mps = kOwnSpeed_mps;
    view.sigma_px = 0.05;
    view.to_s = kSeen_s;
    view.single_lamp = single_lamp;
    const Vehicle ahead{-(kOwnSpeed_mps - 2.0), 0.0, 45.0, 0.0, 0.65, single_lamp ? 0.0 : 1.2};
    VehicleTrack track = track_of(ahead, site, view, random);
    track.kind = LampKind::taillamp;
    track.direction = Direction::receding;
    const VehicleResult result = estimate_vehicle(track, site, {}).result;
    const auto told = std::ranges::find_if(result.warnings, [](const std::string& one) {
      return one.find("measured from 9.03 to 15.00 s alone") != std::string::npos;
    });
    EXPECT_NE(told, result.warnings.end()) << single_lamp;
    EXPECT_NE(result.withheld, Miss::too_few_samples) << single_lamp;
    EXPECT_NE(result.withheld, Miss::too_short) << single_lamp;
  }
}

TEST(Geometry, ACarAheadIsMeasuredWhereOnesOwnPitches) {
  const CarsAhead cars = cars_ahead(4.5, 2.0);
  EXPECT_GE(cars.measured, kCarsAhead - 3);
  EXPECT_GE(cars.inside, 0.9 * cars.measured);
}

// A queue before a low camera: of each car one lamp shows beside the car ahead.
TEST(Geometry, LampsOfTwoCarsOneBehindTheOtherAreNoVehicle) {
  Site site = dashcam_site();
  for (Uncertain* turn_rad :
       {&site.camera->yaw_rad, &site.camera->pitch_rad, &site.camera->roll_rad})
    turn_rad->std = 0.005;
  int ambiguous = 0;
  for (int i = 0; i < 24; ++i) {
    Random random(static_cast<std::uint64_t>(20261126 + i));
    site.camera->position_m[2].mean = random.uniform(1.1, 1.4);
    const double own_mps = random.uniform(5.0, 15.0);
    site.ego = EgoSite{{own_mps, 0.3}, {}, {}};
    View view;
    view.sigma_px = random.uniform(0.1, 0.3);
    view.ego_mps = own_mps;
    view.to_s = random.uniform(1.5, 4.0);
    Vehicle ahead{random.uniform(3.0, 12.0), 0.0, 0.0, 3.5, 0.65 + 0.1 * random.normal(), 1.2};
    ahead.along_m = random.uniform(10.0, 60.0) + view.to_s * (own_mps + ahead.speed_mps);
    Vehicle behind = ahead;
    behind.along_m += random.uniform(8.0, 18.0);
    const VehicleTrack track = simulated::right_lamps_of(track_of(ahead, site, view, random),
                                                         track_of(behind, site, view, random));
    const VehicleResult result = estimate_vehicle(track, site, {}).result;
    EXPECT_TRUE(result.withheld) << i << ": " << result.speed.speed_mps << " for "
                                 << ahead.speed_mps;
    if (result.withheld != Miss::ambiguous_identity) continue;
    ++ambiguous;
    ASSERT_FALSE(result.warnings.empty());
    EXPECT_NE(result.warnings.back().find("may be of two vehicles"), std::string::npos);
  }
  EXPECT_GE(ambiguous, 3);
}

// The road falls off to both sides: an oncoming car leans the other way.
TEST(Geometry, ACarOnACamberedRoadIsStillOne) {
  Site site = dashcam_site();
  site.ego = EgoSite{{15.0, 0.3}, {}, {}};
  View view = kNoiseless;
  view.sigma_px = 0.1;
  view.ego_mps = 15.0;
  const Vehicle vehicle{12.0, 0.0, 80.0, 3.5, 0.65, 1.2};
  Random random(4);
  VehicleTrack track = track_of(vehicle, site, view, random);
  for (VehicleSighting& sighting : track.sightings) {
    const double across_px = sighting.right->centre_px.x() - sighting.left->centre_px.x();
    sighting.left->centre_px.y() -= 0.5 * 0.05 * across_px;
    sighting.right->centre_px.y() += 0.5 * 0.05 * across_px;
  }
  const VehicleResult result = estimate_vehicle(track, site, {}).result;
  ASSERT_FALSE(result.withheld) << name_of(*result.withheld);
  EXPECT_LT(std::abs(result.speed.speed_mps - 12.0), 2.0 * result.speed.std_mps);
}

// Twelve metres a second on a bend of 150 m, seen from its own lane; the other lane is the inner or
// the outer one.
struct BendView {
  Site site = dashcam_site();
  Vehicle vehicle{12.0, 0.0, 60.0, 3.5, 0.65, 1.2};
  View view = kNoiseless;
};

BendView on_a_bend(Turn turn, bool yaw_rates) {
  BendView scene;
  RoadSite& road = scene.site.road;
  road.kind = RoadKind::curved;
  road.turn = turn;
  road.radius_m = Uncertain{150.0, 0.0};
  road.straight_m.mean = 0.0;
  scene.view.ego_mps = 15.0;
  scene.view.ego_yaw_rad_per_s = bend_of(road) * 15.0 / 150.0;
  scene.view.to_s = 1.8;
  if (yaw_rates)
    scene.site.ego->trace = {{-1.0, 15.0, scene.view.ego_yaw_rad_per_s},
                             {5.0, 15.0, scene.view.ego_yaw_rad_per_s}};
  return scene;
}

TEST(Geometry, DashcamOnABend) {
  for (const Turn turn : {Turn::left, Turn::right})
    for (const bool yaw_rates : {false, true}) {
      const BendView scene = on_a_bend(turn, yaw_rates);
      const VehicleResult result = result_of(scene.vehicle, scene.site, scene.view);
      expect_motion(result, scene.vehicle, 1e-3);
      const double bend = bend_of(scene.site.road), lane_radius_m = 150.0 - bend * 3.5;
      const double t_s = result.speed.time_s;
      const double between_rad = (60.0 - 12.0 * t_s) / lane_radius_m - 15.0 * t_s / 150.0;
      EXPECT_NEAR(*result.range_ref_m, lane_radius_m * std::sin(between_rad), 0.05);
      EXPECT_NEAR(*result.lateral_m, 3.5 + bend * lane_radius_m * (1.0 - std::cos(between_rad)),
                  0.02);
      // The lanes' lengths differ: what closes along the vehicle's lane is not the sum of speeds.
      EXPECT_NEAR(*result.closing_speed_mps, 12.0 + 15.0 * lane_radius_m / 150.0, 0.03);
    }
}

TEST(Geometry, YawRatesOfTheWrongSignGiveNoSpeed) {
  BendView scene = on_a_bend(Turn::right, true);
  Random random(1);
  const VehicleTrack track = track_of(scene.vehicle, scene.site, scene.view, random);
  for (EgoSample& sample : scene.site.ego->trace) sample.yaw_rate_rad_per_s *= -1.0;
  const VehicleResult result = estimate_vehicle(track, scene.site, {}).result;
  EXPECT_EQ(result.withheld, Miss::not_on_road);
  ASSERT_FALSE(result.warnings.empty());
  EXPECT_NE(result.warnings[0].find("the other way than the road"), std::string::npos);
}

TEST(Geometry, YawRatesTellARadiusThatTheSiteHasWrong) {
  for (const Turn turn : {Turn::left, Turn::right}) {
    BendView scene = on_a_bend(turn, true);
    const Site truth = scene.site;
    Random random(1);
    const VehicleTrack track = track_of(scene.vehicle, truth, scene.view, random);
    scene.site.road.radius_m = Uncertain{165.0, 30.0};
    const VehicleResult result = estimate_vehicle(track, scene.site, {}).result;
    expect_motion(result, scene.vehicle, 0.01);
  }
}

// Lights by the road, and the ends of lines, are seen together for that long.
TEST(Geometry, BeforeADashcamHalfASecondIsTooShort) {
  BendView scene = on_a_bend(Turn::left, true);
  scene.view.to_s = 0.4;
  EXPECT_EQ(result_of(scene.vehicle, scene.site, scene.view).withheld, Miss::too_short);
  scene.view.to_s = 0.6;
  EXPECT_FALSE(result_of(scene.vehicle, scene.site, scene.view).withheld);
}

}  // namespace
}  // namespace vildar
