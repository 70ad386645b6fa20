#include "estimate/off_road.h"

#include <cmath>

#include <gtest/gtest.h>

#include "simulated_pass.h"

namespace vildar {
namespace {

/// A pair 4 m from its lane's centre and no further lane between: 1.1 widths.
Trajectory far_beside(double lateral_m = -8.0) {
  constexpr double kScale_m = 50.0;
  Trajectory one;
  one.fit.parameters[kLogScale] = std::log(kScale_m);
  one.fit.parameters[kLateral] = lateral_m / kScale_m;
  one.fit.parameters[kDrop] = 3.35 / kScale_m;
  one.weight = 1.0;
  return one;
}

bool is_off(const Trajectory& one) {
  const VehicleTrack track;
  return in_no_lane(track, simulated::mast_site(4.0), std::vector{one});
}

TEST(OffRoad, WhatAPartOfATrackPutsFarBesideTheLanesIsNotBelieved) {
  Trajectory one = far_beside();
  EXPECT_FALSE(is_off(one)) << "a lane that the site file leaves out";
  one.part = true;
  EXPECT_TRUE(is_off(one));
  one.weight = 0.4;
  EXPECT_FALSE(is_off(one)) << "likelier in a lane";
  one.weight = 1.0;
  one.lane = "near";
  EXPECT_FALSE(is_off(one));
}

TEST(OffRoad, APairFartherOffThanOneMoreLaneIsNotBelieved) {
  Trajectory one = far_beside(-10.0);
  EXPECT_TRUE(is_off(one));
  one.fit.covariance(kLateral, kLateral) = std::pow(2.0 / 50.0, 2);
  EXPECT_FALSE(is_off(one)) << "2 m unsure";
}

TEST(OffRoad, APartNearTheLanesIs) {
  Trajectory one = far_beside(-5.0);
  one.part = true;
  EXPECT_FALSE(is_off(one));
}

}  // namespace
}  // namespace vildar
