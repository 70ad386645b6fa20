#include "simulate/site_plan.h"

#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

#include "core/quantity.h"

namespace vildar::simulate {
namespace {

Site mast_site() {
  Site site;
  CameraSite camera;
  camera.width_px = 1920;
  camera.height_px = 1080;
  camera.focal_px = {1400.0, 1400.0};
  camera.principal_px = {959.5, 539.5};
  camera.position_m = {Uncertain{0.0, 0.0}, Uncertain{0.0, 0.0}, Uncertain{4.0, 0.0}};
  camera.pitch_rad.mean = radians_from_degrees(-4.0);
  site.camera = camera;
  site.road.lanes = {{"near", {-4.0, 0.3}, 3.5, Direction::oncoming},
                     {"far", {-7.5, 0.3}, 3.5, Direction::receding}};
  site.lamps.height_m = Uncertain{0.65, 0.1};
  site.lamps.separation_m = Uncertain{1.2, 0.15};
  return site;
}

double relative(const PlanRow& row) { return row.result.speed.std_mps / row.speed_mps; }

TEST(SitePlan, TheScaleIsTheClosedForm) {
  const auto rows = plan_site(mast_site(), {.speeds_kmh = {50.0, 130.0}});
  ASSERT_EQ(rows.size(), 4U);
  const double floor =
      1.0 / std::sqrt(std::pow(4.0 / 0.3, 2) + std::pow(3.35 / 0.1, 2) + std::pow(1.2 / 0.15, 2));
  for (const PlanRow& row : {rows[0], rows[1]}) {
    EXPECT_EQ(row.lane, "near");
    EXPECT_NEAR(relative(row) / floor, 1.0, 0.03);
    EXPECT_GT(row.from_m, 75.0);
    EXPECT_LT(row.to_m, 15.0);
    EXPECT_NEAR(row.seconds * row.speed_mps, row.from_m - row.to_m, 1e-6);
  }
  EXPECT_EQ(rows[2].lane, "far");
  EXPECT_GT(rows[2].to_m, rows[2].from_m) << "a receding vehicle drives away";
}

TEST(SitePlan, ASecondPhotodiodeUpTheRoadBreaksTheScale) {
  Site site = mast_site();
  const PlanRow camera = plan_site(site, {.speeds_kmh = {50.0}}).front();
  site.photodiodes.resize(2);
  for (PhotodiodeSite& photodiode : site.photodiodes)
    photodiode.position_m = site.camera->position_m;
  site.photodiodes[1].position_m[0] = Uncertain{2.0, 0.0};
  site.photodiodes[1].gain_ratio.std = 0.002;
  const PlanRow both = plan_site(site, {.speeds_kmh = {50.0}}).front();
  EXPECT_LT(relative(both), 0.2 * relative(camera));
  EXPECT_EQ(both.result.method, Method::fused);
  EXPECT_GT(both.result.budget->scale_shares.at("photodiode_delay"), 0.9);
}

// Its speed is as sure as K, of 0.3 dB and with D^-2, and where the light ends does not matter.
TEST(SitePlan, TellsWherePhotodiodesAloneWouldBeSurer) {
  Site site = mast_site();
  site.photodiodes.resize(2);
  for (PhotodiodeSite& photodiode : site.photodiodes) {
    photodiode.position_m = {Uncertain{0.0, 0.0}, Uncertain{0.0, 0.0}, Uncertain{4.0, 0.0}};
    photodiode.half_field_of_view_rad = radians_from_degrees(65.0);
  }
  site.photodiodes[1].position_m[0] = Uncertain{2.0, 0.0};
  site.photodiodes[1].gain_ratio.std = 0.002;
  const PlanRow both = plan_site(site, {.speeds_kmh = {75.0}}).front();
  ASSERT_FALSE(both.result.withheld);
  site.camera.reset();
  const PlanRow alone = plan_site(site, {.speeds_kmh = {75.0}}).front();
  ASSERT_FALSE(alone.result.withheld);
  // A user never knows less by a sensor more.
  ASSERT_LT(alone.result.speed.std_mps, both.result.speed.std_mps);
  ASSERT_TRUE(both.light_alone);
  EXPECT_EQ(both.light_alone->std_mps, alone.result.speed.std_mps);
  EXPECT_FALSE(alone.light_alone);
}

TEST(SitePlan, AVehicleThatDrivesAwayHasTheTailLampsOfItsClass) {
  Site site = mast_site();
  site.lamps.classes = {{"car", 1.0, {0.65, 0.1}, Uncertain{1.2, 0.15}}};
  const PlanRow loose = plan_site(site, {.speeds_kmh = {50.0}}).back();
  site.lamps.classes[0].tail_height_m = Uncertain{1.0, 0.01};
  site.lamps.classes[0].tail_separation_m = Uncertain{1.5, 0.01};
  const PlanRow known = plan_site(site, {.speeds_kmh = {50.0}}).back();
  ASSERT_FALSE(loose.result.withheld);
  ASSERT_FALSE(known.result.withheld);
  EXPECT_LT(known.result.speed.std_mps, 0.5 * loose.result.speed.std_mps);
  EXPECT_NEAR(known.result.speed.speed_mps, known.speed_mps, 4.0 * known.result.speed.std_mps);
}

TEST(SitePlan, OnePhotodiodeIsAsSureAtAnySpeed) {
  Site site = mast_site();
  site.photodiodes.resize(1);
  site.photodiodes[0].position_m = site.camera->position_m;
  site.photodiodes[0].half_field_of_view_rad = radians_from_degrees(70.0);
  site.photodiodes[0].time_offset_s = {0.5, 0.0};
  site.camera.reset();
  site.channel.emplace();
  site.channel->gain_db = Uncertain{-42.0, 0.3};
  site.channel->path_loss_exponent = Uncertain{2.0, 0.0};
  const double of_gain = 0.5 * 0.1 * std::log(10.0) * 0.3;
  // A second one at its side brings no delay, and takes nothing away.
  for (int photodiodes = 1; photodiodes <= 2; ++photodiodes) {
    site.photodiodes.resize(photodiodes, site.photodiodes[0]);
    for (const PlanRow& row : plan_site(site, {.speeds_kmh = {30.0, 50.0, 90.0}})) {
      if (row.lane != "near") continue;
      ASSERT_FALSE(row.result.withheld) << row.speed_mps << ": " << name_of(*row.result.withheld);
      EXPECT_GT(relative(row), of_gain) << row.speed_mps;
      EXPECT_LT(relative(row), 1.5 * of_gain) << row.speed_mps;
    }
  }
}

TEST(SitePlan, SaysWhyNothingWouldBeMeasured) {
  Site site = mast_site();
  site.lamps = {};
  site.road.lanes.push_back({"middle", {-2.0, 0.3}, 3.5, Direction::oncoming});
  const PlanRow row = plan_site(site, {.speeds_kmh = {50.0}}).front();
  EXPECT_EQ(row.result.withheld, Miss::no_scale);
  ASSERT_FALSE(row.result.warnings.empty());
  EXPECT_NE(row.result.warnings.front().find("lamps.height_m"), std::string::npos);

  const auto warning_of = [](const Site& planned, const std::string& lane) {
    const auto rows = plan_site(planned, {.speeds_kmh = {50.0}});
    const PlanRow& found = *std::ranges::find(rows, lane, &PlanRow::lane);
    EXPECT_TRUE(found.result.withheld);
    return found.result.warnings.empty() ? "" : found.result.warnings.front();
  };
  Site looks_away = mast_site();
  looks_away.camera->yaw_rad.mean += radians_from_degrees(90.0);
  EXPECT_NE(warning_of(looks_away, "near").find("yaw_deg"), std::string::npos);
  Site light_alone = mast_site();
  light_alone.camera.reset();
  EXPECT_NE(warning_of(light_alone, "far").find("drive away"), std::string::npos);
}

TEST(SitePlan, RefusesWhatItCannotPlan) {
  Site site = mast_site();
  site.ego = EgoSite{};
  EXPECT_THROW(plan_site(site, {}), std::invalid_argument);
  site = mast_site();
  site.road.lanes.clear();
  EXPECT_THROW(plan_site(site, {}), std::invalid_argument);
  PlanOptions options;
  options.frame_rate_hz = 0.0;
  options.farthest_m = -1.0;
  EXPECT_EQ(options.problems().size(), 2U);
  // Each vehicle would take half an hour of frames, or a gigabyte of samples.
  EXPECT_EQ(PlanOptions{.speeds_kmh = {0.1}}.problems().size(), 2U);
  EXPECT_EQ(PlanOptions{.photodiode_rate_hz = 1e6}.problems().size(), 4U);
  EXPECT_TRUE((PlanOptions{.speeds_kmh = {1.0}}.problems().empty()));
  EXPECT_TRUE((PlanOptions{.photodiode_rate_hz = 100e3}.problems().empty()));
}

}  // namespace
}  // namespace vildar::simulate
