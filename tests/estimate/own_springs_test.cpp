#include <algorithm>
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "core/clock.h"
#include "core/quantity.h"
#include "estimate/vehicle.h"
#include "simulated_pass.h"

namespace vildar {
namespace {

using simulated::mast_site;
using simulated::track_of;
using simulated::Vehicle;
using simulated::View;

constexpr double kOwnSpeed_mps = 18.0;

// A motorcycle ahead, told by its elevation alone, while the own car speeds up: its springs lift
// the nose, a fifth of a second late.
TEST(OwnSprings, DoNotPassForTheWayOfALoneLamp) {
  constexpr int kPasses = 40;
  constexpr double kFrom_s = 1.0, kWhile_s = 3.5, kGain_mps = 3.0, kLag_s = 0.2, kStep_s = 0.1;
  const auto done = [=](double time_s) {
    return std::clamp((time_s - kFrom_s) / kWhile_s, 0.0, 1.0);
  };
  const auto speed_mps = [=](double time_s) {
    const double x = done(time_s);
    return kOwnSpeed_mps + kGain_mps * (x - std::sin(2.0 * kPi * x) / (2.0 * kPi));
  };
  const auto rate_mps2 = [=](double time_s) {
    return kGain_mps / kWhile_s * (1.0 - std::cos(2.0 * kPi * done(time_s)));
  };
  const std::function<Eigen::Vector3d(double)> pose = [=](double time_s) {
    const double x = done(time_s), since_s = std::max(0.0, time_s - kFrom_s - kWhile_s);
    const double gained_s =
        kWhile_s * (0.5 * x * x + (std::cos(2.0 * kPi * x) - 1.0) / (4.0 * kPi * kPi)) + since_s;
    return Eigen::Vector3d(kOwnSpeed_mps * time_s + kGain_mps * gained_s, 0.0, 0.0);
  };
  int measured = 0, inside = 0;
  for (int i = 0; i < kPasses; ++i) {
    Random random(static_cast<std::uint64_t>(20261127 + i));
    Site site = mast_site(1.3);
    site.camera->pitch_rad = {0.0, 0.003};
    site.road.lanes = {{"own", {0.0, 0.3}, 3.5, Direction::receding}};
    site.ego = EgoSite{{0.0, 0.1}, {}, {}};
    for (double t_s = -1.0; t_s < 8.0; t_s += kStep_s)
      site.ego->trace.push_back({t_s, speed_mps(t_s) + 0.05 * random.normal(), 0.0});
    const double squat_rad = radians_from_degrees(0.15 + 0.1 * random.normal());
    const double ahead_mps = kOwnSpeed_mps + random.uniform(1.0, 3.0);
    const Vehicle ahead{-ahead_mps,
                        0.0,
                        random.uniform(20.0, 30.0),
                        0.3 * random.normal(),
                        0.65 + 0.1 * random.normal(),
                        0.0};
    View view;
    view.sigma_px = 0.1;
    view.to_s = 5.5;
    view.single_lamp = true;
    view.ego_pose = &pose;
    VehicleTrack track = track_of(ahead, site, view, random);
    track.kind = LampKind::taillamp;
    track.direction = Direction::receding;
    for (VehicleSighting& sighting : track.sightings) {
      sighting.left->centre_px.y() +=
          site.camera->focal_px[1] * squat_rad * rate_mps2(seconds_of(sighting.time) - kLag_s);
    }
    const VehicleResult result = estimate_vehicle(track, site, {}).result;
    if (result.withheld) continue;
    ++measured;
    inside += result.speed.lo95_mps <= ahead_mps && ahead_mps <= result.speed.hi95_mps;
    EXPECT_LT(std::abs(result.speed.speed_mps - ahead_mps), 4.0 * result.speed.std_mps) << i;
  }
  EXPECT_GE(measured, 25);
  EXPECT_GE(inside, 0.9 * measured);
}

}  // namespace
}  // namespace vildar
