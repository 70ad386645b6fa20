#include "track/lone_oncoming.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <utility>

#include "core/quantity.h"
#include "optics/camera.h"
#include "scene.h"

namespace vildar {
namespace {

// A camera on a tripod, 1.3 m up, beside a lane either way.
Site site() {
  Site made = scene::site_of(1.3, 0.0, 1400.0, 1920, 1080);
  made.camera->pitch_rad.std = 0.002;
  made.road.lanes = {{"in", {3.5, 0.3}, 3.5, Direction::oncoming},
                     {"out", {-4.5, 0.3}, 3.5, Direction::receding}};
  return made;
}

std::vector<LampRecord> seen(const Site& site, double lateral_m, double up_m,
                             const std::function<double(double)>& ahead_m) {
  const Camera camera(*site.camera);
  const RoadView view(site);
  std::vector<LampRecord> records;
  for (int frame = 0; frame < 60; ++frame) {
    const double time_s = 0.04 * frame;
    LampRecord& record = records.emplace_back();
    record.time = time_from_seconds<CameraTime>(time_s);
    record.at_px = *view.spot_from_pixel(*camera.project({ahead_m(time_s), lateral_m, up_m}));
  }
  return records;
}

bool passes(const std::vector<LampRecord>& records, LampKind kind) {
  return passes_in_a_lane(records, kind, RoadView(site()));
}

TEST(PassesInALane, AMotorcycleLevelWithTheCameraDoes) {
  for (const double up_m : {0.8, 1.2}) {
    EXPECT_TRUE(passes(seen(site(), 3.5, up_m, [](double t_s) { return 45.0 - 10.0 * t_s; }),
                       LampKind::headlamp));
    EXPECT_TRUE(passes(seen(site(), -4.5, up_m, [](double t_s) { return 12.0 + 10.0 * t_s; }),
                       LampKind::taillamp));
  }
}

// Near the camera half a metre is many pixels.
TEST(PassesInALane, OneThatSpeedsUpOrBrakesOnTheWayDoes) {
  for (const double mps2 : {-0.8, 0.8})
    EXPECT_TRUE(passes(seen(site(), -4.5, 0.8,
                            [&](double t_s) { return 8.0 + 11.0 * t_s + 0.5 * mps2 * t_s * t_s; }),
                       LampKind::taillamp))
        << mps2;
}

TEST(PassesInALane, WhatStandsOrGoesTheOtherWayOrIsHighUpDoesNot) {
  const auto comes = [](double t_s) { return 45.0 - 10.0 * t_s; };
  const auto goes = [](double t_s) { return 12.0 + 10.0 * t_s; };
  EXPECT_FALSE(passes(seen(site(), 3.5, 0.8, [](double) { return 30.0; }), LampKind::headlamp));
  EXPECT_FALSE(passes(seen(site(), 3.5, 0.8, goes), LampKind::headlamp));
  EXPECT_FALSE(passes(seen(site(), -4.5, 0.8, comes), LampKind::headlamp));
  EXPECT_FALSE(passes(seen(site(), 3.5, 4.0, comes), LampKind::headlamp));
  // To and fro as if it turned round.
  EXPECT_FALSE(
      passes(seen(site(), 3.5, 0.8, [](double t_s) { return 20.0 + 15.0 * std::abs(t_s - 1.2); }),
             LampKind::headlamp));
}

TEST(PassesInALane, WhereTheCameraLooksIsKnownNoBetterThanTold) {
  const auto comes = [](double t_s) { return 45.0 - 10.0 * t_s; };
  const auto goes = [](double t_s) { return 12.0 + 10.0 * t_s; };
  for (const double off_deg : {-7.1, -3.25, 3.25, 7.1}) {
    Site truth = site(), told = site();
    truth.camera->yaw_rad.mean += radians_from_degrees(off_deg);
    const auto in = seen(truth, 3.5, 0.8, comes), out = seen(truth, -4.5, 0.8, goes);
    const auto stands = seen(truth, 3.5, 0.8, [](double) { return 30.0; });
    told.camera->yaw_rad.std = radians_from_degrees(5.0);
    const RoadView unsure(told);
    EXPECT_TRUE(passes_in_a_lane(in, LampKind::headlamp, unsure)) << off_deg;
    EXPECT_TRUE(passes_in_a_lane(out, LampKind::taillamp, unsure)) << off_deg;
    EXPECT_FALSE(passes_in_a_lane(out, LampKind::headlamp, unsure)) << off_deg;
    EXPECT_FALSE(passes_in_a_lane(stands, LampKind::headlamp, unsure)) << off_deg;
    told.camera->yaw_rad.std = radians_from_degrees(0.2);
    const RoadView sure(told);
    // Half as far off a way may look like one in the lane.
    if (std::abs(off_deg) < 5.0) continue;
    EXPECT_FALSE(passes_in_a_lane(in, LampKind::headlamp, sure)) << off_deg;
    EXPECT_FALSE(passes_in_a_lane(out, LampKind::taillamp, sure)) << off_deg;
  }
}

TEST(PassesInALane, FewLooksAndBendsTellNothing) {
  std::vector<LampRecord> records =
      seen(site(), 3.5, 0.8, [](double t_s) { return 45.0 - 10.0 * t_s; });
  Site bend = site();
  bend.road.kind = RoadKind::curved;
  bend.road.radius_m = Uncertain{200.0, 0.0};
  EXPECT_FALSE(passes_in_a_lane(records, LampKind::headlamp, RoadView(bend)));
  records.resize(7);
  EXPECT_FALSE(passes(records, LampKind::headlamp));
}

// A dashcam at 11 m/s, 1.3 m up, in a lane 3.5 m wide with another on its left.
Site driving_site() {
  Site made = scene::site_of(1.3, 0.0, 1400.0, 1920, 1080);
  made.camera->pitch_rad.std = radians_from_degrees(0.2);
  made.road.lanes = {{"own", {0.0, 0.0}, 3.5, Direction::receding},
                     {"opp", {3.5, 0.0}, 3.5, Direction::oncoming}};
  made.ego = EgoSite{Uncertain{11.0, 0.1}, {}, {}};
  return made;
}

bool cannot_stand_at(double lateral_m, double up_m, double closing_mps) {
  return cannot_stand(seen(driving_site(), lateral_m, up_m,
                           [&](double t_s) { return 10.0 + closing_mps * (2.4 - t_s); }),
                      RoadView(driving_site()));
}

TEST(CannotStand, ABicycleThatIsOvertakenWouldStandInTheLaneOrBelowTheRoad) {
  EXPECT_TRUE(cannot_stand_at(0.0, 0.8, 6.0));
  EXPECT_TRUE(cannot_stand_at(0.4, 0.8, 6.0));
  EXPECT_TRUE(cannot_stand_at(-1.5, 0.5, 3.5));
}

TEST(CannotStand, PostsAndLightsOverTheLaneCan) {
  for (const double lateral_m : {-2.5, -4.0, 6.0})
    for (const double up_m : {0.4, 0.9, 3.0})
      EXPECT_FALSE(cannot_stand_at(lateral_m, up_m, 11.0)) << lateral_m << " " << up_m;
  EXPECT_FALSE(cannot_stand_at(0.0, 4.5, 11.0));
}

// It may as well be a post, farther off.
TEST(CannotStand, ABicycleByTheKerbMay) { EXPECT_FALSE(cannot_stand_at(-1.5, 0.8, 6.0)); }

}  // namespace
}  // namespace vildar
