#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "delay_pass.h"
#include "estimate/vehicle.h"
#include "two_traces.h"

namespace vildar {
namespace {

struct Driven {
  double speed_mps, aside2_m2;
};

// The power law's light of vehicles that all come abeam at 4 s, before two photodiodes 2 m apart.
std::vector<PowerTrace> traces_of(const std::vector<Driven>& vehicles, Random& random) {
  constexpr double kNoise_w = 1e-3, kAbeam_s = 4.0;
  return simulated::two_traces(1.1 * kAbeam_s, kNoise_w, random, [&](int k, double t_s) {
    double light_w = 0.0;
    for (const Driven& vehicle : vehicles) {
      const double ahead_m = vehicle.speed_mps * (kAbeam_s - t_s) - 2.0 * k;
      if (ahead_m > 0.0) light_w += 100.0 / (ahead_m * ahead_m + vehicle.aside2_m2);
    }
    return light_w;
  });
}

// Milliwatts in a column of watts.
TEST(Pass, LightThatNoLampInTheLaneGivesNamesGainAndUnit) {
  Site site = simulated::two_photodiodes(2.0);
  site.photodiodes.resize(1);
  site.channel = ChannelSite{};
  site.channel->gain_db = Uncertain{20.0, 1.0};
  site.channel->path_loss_exponent = Uncertain{2.0, 0.02};
  for (const float factor : {1.0F, 1000.0F}) {
    Random random(4);
    auto traces = traces_of({{20.0, 27.0}}, random);
    for (float& power_w : traces[0].power_w) power_w *= factor;
    traces[0].noise_sigma_w *= factor;
    const auto result = estimate_pass({.from_s = 0.0, .to_s = 4.2, .peak_s = 3.99}, 1, site,
                                      std::span(traces).first(1));
    const bool told = std::ranges::any_of(result.warnings, [](const std::string& warning) {
      return warning.find("channel.gain_db") != std::string::npos &&
             warning.find("the unit of the trace") != std::string::npos;
    });
    EXPECT_EQ(told, factor > 1.0F) << factor;
    EXPECT_EQ(result.withheld == Miss::outside_model, factor > 1.0F) << factor;
    EXPECT_EQ(result.withheld.has_value(), factor > 1.0F) << factor;
  }
}

// The reason is the photodiodes', though the power methods come first and want a gain.
TEST(Pass, PhotodiodesThatDenyTheirGainsAreNamed) {
  Random random(4);
  auto traces = traces_of({{20.0, 27.0}}, random);
  for (float& power_w : traces[1].power_w) power_w *= 1.1F;
  const auto result = estimate_pass({.from_s = 0.0, .to_s = 4.2, .peak_s = 3.99}, 1,
                                    simulated::two_photodiodes(2.0), traces);
  EXPECT_EQ(result.withheld, Miss::sensors_contradict);
  EXPECT_EQ(result.method, Method::delay_photodiodes);
}

// Of a pass that clips until just before its lamps are gone.
TEST(Pass, ThatIsClippedForMostOfItsTimeIsSaturated) {
  Random random(5);
  auto traces = traces_of({{20.0, 27.0}}, random);
  constexpr double kClippedTo_s = 3.95;
  for (PowerTrace& trace : traces) {
    const auto kept = std::ranges::upper_bound(trace.time_s, kClippedTo_s) - trace.time_s.begin();
    trace.time_s.erase(trace.time_s.begin(), trace.time_s.begin() + kept);
    trace.power_w.erase(trace.power_w.begin(), trace.power_w.begin() + kept);
  }
  const PowerPass pass{.from_s = kClippedTo_s, .to_s = 4.1, .peak_s = kClippedTo_s + 0.005};
  const Site site = simulated::two_photodiodes(2.0);
  EXPECT_NE(estimate_pass(pass, 1, site, traces).withheld, Miss::saturated);
  for (PowerTrace& trace : traces) trace.clipped = {{kClippedTo_s - 0.1, kClippedTo_s}};
  EXPECT_NE(estimate_pass(pass, 1, site, traces).withheld, Miss::saturated) << "less of it";
  for (PowerTrace& trace : traces) trace.clipped = {{0.0, kClippedTo_s}};
  const VehicleResult result = estimate_pass(pass, 1, site, traces);
  EXPECT_EQ(result.withheld, Miss::saturated);
  for (const MethodResult& row : result.methods)
    if (const Miss* miss = std::get_if<Miss>(&row.speed); miss && *miss != Miss::no_scale) {
      EXPECT_EQ(*miss, Miss::saturated) << name_of(row.method);
    }
}

class Abreast : public ::testing::Test {
 protected:
  VehicleResult result_of(const std::vector<Driven>& vehicles) {
    return estimate_pass({.from_s = 0.0, .to_s = 4.2, .peak_s = 3.99}, 1, site_,
                         traces_of(vehicles, random_));
  }

  static constexpr double kNear2_m2 = 27.0, kFar2_m2 = 67.0;
  Site site_ = simulated::two_photodiodes(2.0);
  Random random_{3};
};

TEST_F(Abreast, TheMixtureOfTwoIsNoSpeed) {
  site_.road.lanes.push_back({"far", {-7.5, 0.3}, 3.5, Direction::oncoming});
  for (const double faster : {0.8, 0.9, 1.1, 1.2, 1.3}) {
    const auto result = result_of({{20.0, kNear2_m2}, {20.0 * faster, kFar2_m2}});
    EXPECT_EQ(result.withheld, Miss::several_vehicles) << faster;
  }
}

TEST_F(Abreast, OneAloneHasItsSpeedInEitherLane) {
  site_.road.lanes.push_back({"far", {-7.5, 0.3}, 3.5, Direction::oncoming});
  for (const double aside2_m2 : {kNear2_m2, kFar2_m2}) {
    const auto result = result_of({{20.0, aside2_m2}});
    ASSERT_FALSE(result.withheld) << name_of(*result.withheld);
    EXPECT_EQ(result.method, Method::delay_photodiodes);
    EXPECT_LT(std::abs(result.speed.speed_mps - 20.0), 4.0 * result.speed.std_mps);
  }
}

// A camera that sees the vehicle of the near lane alone, up to 12 m before it.
class BesideACamera : public Abreast {
 protected:
  BesideACamera() {
    site_.camera = simulated::mast_site(4.0).camera;
    site_.road.lanes.push_back({"far", {-7.5, 0.3}, 3.5, Direction::oncoming});
  }
  VehicleResult seen_with(const std::vector<PowerTrace>& traces, const Site& site,
                          const PowerTrace* own_light = nullptr,
                          const std::optional<OwnPass>& own_pass = {}) {
    const simulated::Vehicle near{20.0, 0.0, 80.0, -4.0, 0.65, 1.2};
    const VehicleTrack track = track_of(near, site, {.from_s = 0.5, .to_s = 3.4}, random_);
    const std::vector<VehiclePower> power{{&traces[0], false, own_light},
                                          {&traces[1], false, own_light}};
    return estimate_vehicle(track, site, power, own_pass).result;
  }
  static const MethodResult& delay_in(const VehicleResult& result) {
    return *std::ranges::find(result.methods, Method::delay_photodiodes, &MethodResult::method);
  }
};

TEST_F(BesideACamera, OneThatItDoesNotSeeLeavesTheSpeedToIt) {
  for (const double faster : {0.8, 0.9, 1.1, 1.2, 1.3}) {
    const auto traces = traces_of({{20.0, kNear2_m2}, {20.0 * faster, kFar2_m2}}, random_);
    const VehicleResult result = seen_with(traces, site_);
    ASSERT_FALSE(result.withheld) << faster << name_of(*result.withheld);
    EXPECT_EQ(result.method, Method::geometry_camera) << faster;
    EXPECT_EQ(std::get<Miss>(delay_in(result).speed), Miss::several_vehicles) << faster;
    EXPECT_LT(std::abs(result.speed.speed_mps - 20.0), 4.0 * result.speed.std_mps) << faster;
    // Nor does light stand in where the camera has no scale.
    Site no_scale = site_;
    no_scale.lamps = {};
    for (LaneSite& lane : no_scale.road.lanes) lane.lateral_m.std = 3.0;
    EXPECT_EQ(seen_with(traces, no_scale).withheld, Miss::no_scale) << faster;
  }
}

TEST_F(BesideACamera, OneAloneIsMeasuredByBoth) {
  const VehicleResult result = seen_with(traces_of({{20.0, kNear2_m2}}, random_), site_);
  ASSERT_FALSE(result.withheld) << name_of(*result.withheld);
  EXPECT_EQ(result.method, Method::fused);
  EXPECT_LT(result.speed.std_mps, 0.2);  // 0.5 of the camera alone
  EXPECT_LT(std::abs(result.speed.speed_mps - 20.0), 4.0 * result.speed.std_mps);
}

// Photodiodes that stand 2 m apart, where the site says 20.
TEST_F(BesideACamera, ADelayFasterThanVehiclesDriveIsNoSpeed) {
  Site wrong = site_;
  wrong.photodiodes[1].position_m[0].mean = 20.0;
  const VehicleResult result = seen_with(traces_of({{20.0, kNear2_m2}}, random_), wrong);
  EXPECT_EQ(std::get<Miss>(delay_in(result).speed), Miss::outside_model);
  EXPECT_TRUE(std::ranges::any_of(result.warnings, [](const std::string& warning) {
    return warning.find("faster than vehicles drive") != std::string::npos;
  }));
  ASSERT_FALSE(result.withheld) << name_of(*result.withheld);
  EXPECT_LT(std::abs(result.speed.speed_mps - 20.0), 4.0 * result.speed.std_mps);
}

// Light that seems to brake by 2.8 m/s^2, as that of a follower beside the own may, at about the
// speed that the camera sees: of one speed the camera's stands; 30 % off neither can be trusted
// where the photodiodes are known to be alike.
TEST_F(BesideACamera, ADelayThatDeniesTheAccelerationAloneLeavesTheSpeedToIt) {
  for (const double times : {1.0, 1.3}) {
    Site one_lane = site_;
    one_lane.road.lanes.pop_back();
    if (times > 1.0) one_lane.photodiodes[1].gain_ratio.std = 2e-4;
    const auto traces = simulated::two_traces(4.4, 1e-3, random_, [&](int k, double t_s) {
      const double to_go_s = 4.0 - t_s;
      const double ahead_m = times * (20.0 * to_go_s + 0.5 * 2.8 * to_go_s * to_go_s) - 2.0 * k;
      return ahead_m > 0.0 ? 100.0 / (ahead_m * ahead_m + kNear2_m2) : 0.0;
    });
    const VehicleResult result = seen_with(traces, one_lane);
    if (times > 1.0) {
      EXPECT_EQ(result.withheld, Miss::sensors_contradict);
      continue;
    }
    ASSERT_FALSE(result.withheld) << name_of(*result.withheld);
    EXPECT_EQ(result.method, Method::geometry_camera);
    EXPECT_LT(std::abs(result.speed.speed_mps - 20.0), 4.0 * result.speed.std_mps);
    ASSERT_FALSE(result.warnings.empty());
    EXPECT_NE(result.warnings[0].find("speed or acceleration"), std::string::npos);
  }
}

// The delay is the same by any clock; the place of the light is not.
TEST_F(BesideACamera, AClockThatIsOffLeavesTheSpeedToIt) {
  for (const double late_s : {-1.0, 0.6}) {
    auto traces = traces_of({{20.0, kNear2_m2}}, random_);
    for (PowerTrace& trace : traces)
      for (double& time_s : trace.time_s) time_s += late_s;
    const VehicleResult result = seen_with(traces, site_);
    ASSERT_FALSE(result.withheld) << late_s << name_of(*result.withheld);
    EXPECT_EQ(result.method, Method::geometry_camera) << late_s;
    EXPECT_EQ(std::get<Miss>(delay_in(result).speed), Miss::sensors_contradict) << late_s;
    ASSERT_FALSE(result.warnings.empty()) << late_s;
    EXPECT_NE(result.warnings[0].find("check both clocks"), std::string::npos) << late_s;
  }
}

// Where light does not fit the bearings for other reasons, as that of others, another clock may fit
// by chance; a pass that was found at the time of the vehicle is its own by the clock as it is.
TEST_F(BesideACamera, NoClockIsDoubtedByWhichTheVehiclesOwnPassEnds) {
  auto traces = traces_of({{20.0, kNear2_m2}}, random_);
  for (PowerTrace& trace : traces)
    for (double& time_s : trace.time_s) time_s += 0.6;
  PowerPass pass;
  pass.from_s = traces[0].time_s.front();
  pass.peak_s = pass.to_s = 4.0 + 0.6;
  const VehicleResult result = seen_with(traces, site_, nullptr, OwnPass{pass, traces});
  ASSERT_TRUE(std::holds_alternative<SpeedEstimate>(delay_in(result).speed));
  EXPECT_LT(std::abs(std::get<SpeedEstimate>(delay_in(result).speed).speed_mps - 20.0), 0.2);
  EXPECT_TRUE(std::ranges::none_of(result.warnings, [](const std::string& warning) {
    return warning.find("check both clocks") != std::string::npos;
  }));
}

TEST_F(BesideACamera, AClockToldLooselyIsFoundFromTheLight) {
  for (const double late_s : {-0.7, -0.4, 0.4, 0.7}) {
    Site site = site_;
    for (PhotodiodeSite& diode : site.photodiodes) diode.time_offset_s = {0.0, 0.4};
    auto traces = traces_of({{20.0, kNear2_m2}}, random_);
    for (PowerTrace& trace : traces)
      for (double& time_s : trace.time_s) time_s += late_s;
    const VehicleResult result = seen_with(traces, site);
    ASSERT_FALSE(result.withheld) << late_s << name_of(*result.withheld);
    EXPECT_EQ(result.method, Method::fused) << late_s;
    EXPECT_LT(result.speed.std_mps, 0.25) << late_s;  // 0.5 of the camera alone
    EXPECT_LT(std::abs(result.speed.speed_mps - 20.0), 3.0 * result.speed.std_mps) << late_s;
  }
}

// A wrong clock cuts the traces to another vehicle's time, and theirs is its motion.
TEST_F(BesideACamera, LightThatTheVehiclesInViewDoNotExplainTellsNoDelay) {
  const PowerTrace unexplained;
  const VehicleResult result =
      seen_with(traces_of({{20.0, kNear2_m2}}, random_), site_, &unexplained);
  ASSERT_FALSE(result.withheld) << name_of(*result.withheld);
  EXPECT_EQ(result.method, Method::geometry_camera);
  EXPECT_EQ(std::get<Miss>(delay_in(result).speed), Miss::several_vehicles);
}

TEST_F(BesideACamera, LampsThatPulseTellNoDelay) {
  auto traces = traces_of({{20.0, kNear2_m2}}, random_);
  for (PowerTrace& trace : traces)
    for (std::size_t i = 0; i < trace.time_s.size(); ++i) {
      const double phase = 137.0 * trace.time_s[i];
      trace.power_w[i] *= phase - std::floor(phase) < 0.4 ? 2.5F : 0.0F;
    }
  const VehicleResult result = seen_with(traces, site_);
  ASSERT_FALSE(result.withheld) << name_of(*result.withheld);
  EXPECT_EQ(result.method, Method::geometry_camera);
  EXPECT_FALSE(result.used_photodiode);
  EXPECT_EQ(std::get<Miss>(delay_in(result).speed), Miss::outside_model);
  EXPECT_LT(std::abs(result.speed.speed_mps - 20.0), 4.0 * result.speed.std_mps);
}

}  // namespace
}  // namespace vildar
