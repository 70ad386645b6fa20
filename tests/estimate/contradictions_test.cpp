#include "estimate/contradictions.h"

#include <cmath>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

namespace vildar {
namespace {

// A camera that says 20 m/s to 3 %.
std::vector<Trajectory> camera() {
  Trajectory one;
  one.fit.parameters[kLogScale] = std::log(50.0);
  one.fit.parameters[kClosingRate] = 20.0 / 50.0;
  one.fit.covariance(kLogScale, kLogScale) = 0.03 * 0.03;
  return {one};
}

VehicleResult beside(Method reported, Method other, double speed_mps, double std_mps) {
  VehicleResult result;
  result.method = reported;
  SpeedEstimate speed;
  speed.speed_mps = speed_mps;
  speed.std_mps = std_mps;
  result.methods.push_back({other, speed, 100, "site"});
  check_sensors(camera(), result);
  return result;
}

TEST(Contradictions, WhatAgreesIsNotTold) {
  const auto result = beside(Method::geometry_camera, Method::ml_photodiode, 19.0, 0.3);
  EXPECT_TRUE(result.warnings.empty());
  EXPECT_FALSE(result.withheld);
}

TEST(Contradictions, NeitherOfTwoSureSensorsIsTrusted) {
  const auto result = beside(Method::geometry_camera, Method::ml_photodiode, 15.0, 0.3);
  EXPECT_EQ(result.warnings.size(), 1U);
  EXPECT_EQ(result.withheld, Miss::sensors_contradict);
}

TEST(Contradictions, TheCameraStandsAgainstAMuchLessSureLight) {
  const auto result = beside(Method::geometry_camera, Method::ml_photodiode, 12.0, 1.5);
  EXPECT_EQ(result.warnings.size(), 1U);
  EXPECT_FALSE(result.withheld);
}

// What rests on the law alone is then no speed; a delay rests on none.
TEST(Contradictions, WhereLightAndBearingsFitTogetherTheLawIsWrongAndNotTheLight) {
  for (const Method method :
       {Method::power_slope_photodiode, Method::ml_photodiode, Method::delay_photodiodes}) {
    const auto result = beside(Method::fused, method, 15.0, 0.3);
    EXPECT_EQ(result.warnings.size(), 1U) << name_of(method);
    EXPECT_FALSE(result.withheld) << name_of(method);
    const Miss* miss = std::get_if<Miss>(&result.methods.front().speed);
    EXPECT_EQ(miss != nullptr, method != Method::delay_photodiodes) << name_of(method);
    if (miss) {
      EXPECT_EQ(*miss, Miss::outside_model) << name_of(method);
    }
  }
}

// A delay rests on no law: that the power fits badly says nothing of it.
TEST(Contradictions, LightThatNoBeamExplainsIsTrustedForNoSpeedByItsLaw) {
  for (const auto& [method, withheld] :
       {std::pair(Method::ml_photodiode, false), std::pair(Method::power_slope_photodiode, false),
        std::pair(Method::delay_photodiodes, true)}) {
    VehicleResult result;
    result.method = Method::geometry_camera;
    SpeedEstimate speed;
    speed.speed_mps = 15.0;
    speed.std_mps = 0.3;
    result.methods.push_back({method, speed, 100, "site"});
    result.methods.push_back({Method::fused, Miss::bad_fit, 100, ""});
    check_sensors(camera(), result);
    EXPECT_EQ(result.warnings.size(), 1U) << name_of(method);
    EXPECT_EQ(result.withheld.has_value(), withheld) << name_of(method);
  }
}

TEST(Contradictions, TheCamerasOwnLightIsNoSecondSensor) {
  const auto result = beside(Method::geometry_camera, Method::power_slope_camera, 15.0, 0.3);
  EXPECT_TRUE(result.warnings.empty());
}

SpeedEstimate speed_of(double speed_mps) {
  SpeedEstimate speed;
  speed.speed_mps = speed_mps;
  speed.std_mps = 0.02 * speed_mps;
  return speed;
}

// Passes of 20 m/s by their delays, of which `denied` have light that says 10 m/s under the law;
// and one that rests on the law alone.
std::vector<VehicleResult> passes_by(int denied, int agreed) {
  std::vector<VehicleResult> passes(static_cast<std::size_t>(denied + agreed) + 1);
  for (VehicleResult& pass : passes) {
    const bool by_law = &pass == &passes.back();
    pass.method = by_law ? Method::power_slope_photodiode : Method::delay_photodiodes;
    const bool denies = &pass - passes.data() < denied;
    pass.methods = {
        {Method::power_slope_photodiode, speed_of(denies || by_law ? 10.0 : 20.0), 100, "site"},
        {Method::delay_photodiodes, by_law ? Outcome<SpeedEstimate>(Miss::bad_fit) : speed_of(20.0),
         100, ""}};
  }
  check_law(passes);
  return passes;
}

TEST(Contradictions, ALawThatMostDelaysDenyGivesNoSpeedAlone) {
  for (const auto& [denied, agreed, stands] : {std::tuple(2, 1, false), std::tuple(1, 0, true),
                                               std::tuple(2, 2, true), std::tuple(3, 2, false)}) {
    const auto passes = passes_by(denied, agreed);
    EXPECT_EQ(!passes.back().withheld, stands) << denied << " of " << denied + agreed;
    if (!stands) {
      EXPECT_EQ(passes.back().withheld, Miss::outside_model);
      EXPECT_EQ(passes.back().warnings.size(), 1U);
    }
    EXPECT_FALSE(passes.front().withheld);
  }
}

}  // namespace
}  // namespace vildar
