#include "estimate/own_springs.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "core/clock.h"
#include "estimate/recursive_fit.h"
#include "estimate/vehicle.h"
#include "simulated_pass.h"

namespace vildar {
namespace {

using simulated::mast_site;
using simulated::track_of;
using simulated::Vehicle;
using simulated::View;

constexpr double kOwnSpeed_mps = 18.0, kLag_s = 0.2;
constexpr double kFrom_s = 1.0, kWhile_s = 3.5, kGain_mps = 3.0;

// From 18 to 21 m/s.
double done(double time_s) { return std::clamp((time_s - kFrom_s) / kWhile_s, 0.0, 1.0); }
double own_mps(double time_s) {
  const double x = done(time_s);
  return kOwnSpeed_mps + kGain_mps * (x - std::sin(2.0 * kPi * x) / (2.0 * kPi));
}
double own_mps2(double time_s) {
  return kGain_mps / kWhile_s * (1.0 - std::cos(2.0 * kPi * done(time_s)));
}
double own_way_m(double time_s) {
  const double x = done(time_s), since_s = std::max(0.0, time_s - kFrom_s - kWhile_s);
  const double gained_s =
      kWhile_s * (0.5 * x * x + (std::cos(2.0 * kPi * x) - 1.0) / (4.0 * kPi * kPi)) + since_s;
  return kOwnSpeed_mps * time_s + kGain_mps * gained_s;
}

/// A motorcycle ahead, told by its elevation alone, while the own car speeds up: its springs lift
/// the nose, a fifth of a second late.
struct Pass {
  Site site = mast_site(1.3);
  VehicleTrack track;
  double ahead_mps = 0.0;

  explicit Pass(std::uint64_t seed) {
    constexpr double kStep_s = 0.1, kNoise_mps = 0.05;
    Random random(seed);
    site.camera->pitch_rad = {0.0, 0.003};
    site.road.lanes = {{"own", {0.0, 0.3}, 3.5, Direction::receding}};
    site.ego = EgoSite{{0.0, 0.1}, {}, {}};
    for (double t_s = -1.0; t_s < 8.0; t_s += kStep_s)
      site.ego->trace.push_back({t_s, own_mps(t_s) + kNoise_mps * random.normal(), 0.0});
    const double squat = radians_from_degrees(0.15 + 0.1 * random.normal());
    ahead_mps = kOwnSpeed_mps + random.uniform(1.0, 3.0);
    const Vehicle ahead{-ahead_mps,
                        0.0,
                        random.uniform(20.0, 30.0),
                        0.3 * random.normal(),
                        0.65 + 0.1 * random.normal(),
                        0.0};
    const std::function<Eigen::Vector3d(double)> pose = [](double time_s) {
      return Eigen::Vector3d(own_way_m(time_s), 0.0, 0.0);
    };
    View view;
    view.sigma_px = 0.1;
    view.to_s = 5.5;
    view.single_lamp = true;
    view.ego_pose = &pose;
    track = track_of(ahead, site, view, random);
    track.kind = LampKind::taillamp;
    track.direction = Direction::receding;
    for (VehicleSighting& sighting : track.sightings)
      sighting.left->centre_px.y() +=
          site.camera->focal_px[1] * squat * own_mps2(seconds_of(sighting.time) - kLag_s);
  }
};

constexpr int kPasses = 40;

void expect_holds(double most_sigmas,
                  const std::function<std::optional<SpeedEstimate>(const Pass&)>& speed_of) {
  int measured = 0, inside = 0;
  for (int i = 0; i < kPasses; ++i) {
    const Pass pass(static_cast<std::uint64_t>(20261127 + i));
    const auto speed = speed_of(pass);
    if (!speed) continue;
    ++measured;
    inside += speed->lo95_mps <= pass.ahead_mps && pass.ahead_mps <= speed->hi95_mps;
    EXPECT_LT(std::abs(speed->speed_mps - pass.ahead_mps), most_sigmas * speed->std_mps) << i;
  }
  EXPECT_GE(measured, 25);
  EXPECT_GE(inside, 0.9 * measured);
}

TEST(OwnSprings, DoNotPassForTheWayOfALoneLamp) {
  expect_holds(4.0, [](const Pass& pass) -> std::optional<SpeedEstimate> {
    const VehicleResult result = estimate_vehicle(pass.track, pass.site, {}).result;
    if (result.withheld) return std::nullopt;
    return result.speed;
  });
}

// Its first fit is of a third of a second before the car speeds up. One of the forty is far off, as
// it is at a constant own speed.
TEST(OwnSprings, NorInTheRecursiveFit) {
  expect_holds(INFINITY, [](const Pass& pass) -> std::optional<SpeedEstimate> {
    RecursiveFit fit(pass.site, pass.track, {});
    for (const VehicleSighting& sighting : pass.track.sightings) fit.add(sighting);
    const auto outcome = fit.speed();
    if (std::holds_alternative<Miss>(outcome)) return std::nullopt;
    return std::get<SpeedEstimate>(outcome);
  });
}

TEST(OwnSprings, AreKnownToAShareOfTheTurnForASecond) {
  const double turn_rad = radians_from_degrees(0.15) * 2.0;
  EgoDeviation own;
  own.springs_mps2 = -2.0;
  EXPECT_NEAR(springs_sigma_rad(own, 1.0), 0.15 * turn_rad, 1e-12);
  EXPECT_NEAR(springs_sigma_rad(own, 30.0), 0.15 * turn_rad * std::sqrt(30.0), 1e-12);
  own.springs_sigma_mps2 = 0.4;
  EXPECT_NEAR(springs_sigma_rad(own, 1.0), std::hypot(0.15, 0.2) * turn_rad, 1e-12);
}

}  // namespace
}  // namespace vildar
