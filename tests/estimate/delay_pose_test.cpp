#include "estimate/delay_pose.h"

#include <gtest/gtest.h>

#include "delay_pair.h"
#include "support/trials.h"

namespace vildar {
namespace {

using simulated::pair_of;
using simulated::two_photodiodes;

Outcome<PairPose> pose_of(const Site& site) {
  return pair_pose(site, site.photodiodes[0], site.photodiodes[1]);
}

void bend_road(Site& site, Turn turn, Uncertain radius_m, double straight_m = 0.0) {
  site.road.kind = RoadKind::curved;
  site.road.turn = turn;
  site.road.radius_m = radius_m;
  site.road.straight_m.mean = straight_m;
}

TEST(DelayPose, OnAStraightRoadPhotodiodesThatStandAlikeAreAlike) {
  const auto pose = std::get<PairPose>(pose_of(two_photodiodes(2.0, 0.002, 0.01)));
  EXPECT_DOUBLE_EQ(pose.baseline_m.mean, 2.0);
  EXPECT_DOUBLE_EQ(pose.baseline_m.std, 0.01);
  EXPECT_NEAR(pose.perpendicular_m, std::hypot(4.0, 4.0 - 0.65), 1e-9);
  EXPECT_TRUE(pose.unlike.empty());
}

// The way in a lane is that of the line y = 0 in proportion to the radii.
TEST(DelayPose, OnABendEachLaneHasAWayOfItsOwn) {
  for (const Turn turn : {Turn::left, Turn::right}) {
    Site site = two_photodiodes(2.0);
    bend_road(site, turn, {200.0, 0.0});
    const double bend = turn == Turn::left ? 1.0 : -1.0;
    const auto pose = std::get<PairPose>(pose_of(site));
    const double turned_rad = std::atan2(2.0, 200.0);
    EXPECT_NEAR(pose.baseline_m.mean, turned_rad * (200.0 - bend * -4.0), 1e-9);
    const double by_place_m = turned_rad * 0.3;  // a sigma of 0.3 m in the lane
    EXPECT_NEAR(pose.baseline_m.std, by_place_m, 1e-6);
    site.road.lanes.push_back({"far", {-8.0, 0.3}, 3.5, Direction::oncoming});
    const auto either = std::get<PairPose>(pose_of(site));
    EXPECT_NEAR(either.baseline_m.mean, turned_rad * (200.0 - bend * -6.0), 1e-9);
    EXPECT_NEAR(either.baseline_m.std, std::hypot(by_place_m, turned_rad * 4.0 / std::sqrt(12.0)),
                3e-4);
  }
}

// Where the lane lies 4 m beside the line whose radius is told.
TEST(DelayPose, TheSigmaOfTheRadiusIsThatOfTheWay) {
  Site site = two_photodiodes(2.0);
  site.road.lanes[0].lateral_m.std = 0.0;
  bend_road(site, Turn::left, {150.0, 10.0});
  const auto pose = std::get<PairPose>(pose_of(site));
  // d(2 m (R + 4) / R) / dR = -8 / R^2.
  EXPECT_NEAR(pose.baseline_m.std, 8.0 / (150.0 * 150.0) * 10.0, 1e-4);
}

// Far off light comes along the road, and turned by so much from one's axis its cosine is less.
TEST(DelayPose, PhotodiodesTurnedApartReceiveByTheirCosines) {
  constexpr double kFirst_rad = -0.30, kSecond_rad = -0.31;
  Site site = two_photodiodes(2.0);
  site.photodiodes[0].yaw_rad = kFirst_rad;
  site.photodiodes[1].yaw_rad = kSecond_rad;
  const auto pose = std::get<PairPose>(pose_of(site));
  for (const double ahead_m : {20.0, 60.0}) {
    const double azimuth_rad = std::atan2(-4.0, ahead_m);
    const UnlikeLight unlike = unlike_at(pose.unlike, ahead_m);
    EXPECT_NEAR(unlike.log_ratio,
                std::log(std::cos(azimuth_rad - kSecond_rad) / std::cos(azimuth_rad - kFirst_rad)),
                1e-4);
    EXPECT_GT(unlike.doubt, 0.25 * std::abs(unlike.log_ratio));
  }
}

TEST(DelayPose, WhatStandsTooUnlikeIsNoPair) {
  Site site = two_photodiodes(2.0);
  site.photodiodes[1].position_m[1].mean = 3.0;
  EXPECT_EQ(std::get<Miss>(pose_of(site)), Miss::outside_model);
  site = two_photodiodes(2.0);
  site.photodiodes[1].yaw_rad = 0.4;
  EXPECT_EQ(std::get<Miss>(pose_of(site)), Miss::outside_model);
  site = two_photodiodes(2.0);
  bend_road(site, Turn::left, {100.0, 0.0});
  site.road.radius_m.reset();
  EXPECT_EQ(std::get<Miss>(pose_of(site)), Miss::outside_model);
  EXPECT_EQ(std::get<Miss>(pose_of(two_photodiodes(0.05))), Miss::no_scale);
  site = two_photodiodes(2.0);
  site.photodiodes[1].yaw_rad = kPi;  // sees nothing of what the other does
  EXPECT_EQ(std::get<Miss>(pose_of(site)), Miss::outside_model);
}

struct Tried {
  int measured = 0, inside = 0;
  double worst_sigmas = 0.0, median_share = 0.0;
};

// Vehicles with beams that the estimator does not know, at truths drawn from what the site says.
Tried tried(const Site& site, int trials) {
  Random random(41);
  Tried found;
  std::vector<double> shares;
  for (int trial = 0; trial < trials; ++trial) {
    const simulated::Vehicle vehicle = simulated::random_vehicle(0.5, random);
    Site truth = site;
    if (truth.road.radius_m)
      truth.road.radius_m->mean += truth.road.radius_m->std * random.normal();
    const auto outcome =
        pair_of(vehicle, truth, {}, 1.0, 0.0, simulated::random_beam(0.1, random)).speed(site);
    const auto* fit = std::get_if<DelayFit>(&outcome);
    if (!fit) continue;
    ++found.measured;
    const double sigmas = std::abs(fit->speed.speed_mps - vehicle.speed_at_mps(fit->speed.time_s)) /
                          fit->speed.std_mps;
    found.inside += sigmas < 2.0;
    found.worst_sigmas = std::max(found.worst_sigmas, sigmas);
    shares.push_back(fit->speed.std_mps / fit->speed.speed_mps);
  }
  std::sort(shares.begin(), shares.end());
  if (!shares.empty()) found.median_share = shares[shares.size() / 2];
  return found;
}

TEST(DelayPose, SpeedsOnBends) {
  constexpr int kTrials = trials(40), kMostOutside = kTrials / 10 + 1;  // two of 40 expected
  for (const Turn turn : {Turn::left, Turn::right})
    for (const double radius_m : {80.0, 150.0, 400.0}) {
      Site site = two_photodiodes(2.0);
      bend_road(site, turn, {radius_m, 0.1 * radius_m});
      const Tried found = tried(site, kTrials);
      const auto told = ::testing::Message() << (turn == Turn::left ? "left " : "right ")
                                             << radius_m << " m, sigma " << found.median_share;
      EXPECT_EQ(found.measured, kTrials) << told;
      EXPECT_GE(found.inside, kTrials - kMostOutside) << told;
      EXPECT_LT(found.worst_sigmas, 4.0) << told;
      EXPECT_LT(found.median_share, 0.02) << told;
    }
}

// It would begin at another distance from each.
TEST(DelayPose, ABendThatBeginsAheadIsNoModel) {
  Site site = two_photodiodes(2.0);
  bend_road(site, Turn::left, {300.0, 10.0}, 10.0);
  EXPECT_EQ(std::get<Miss>(pose_of(site)), Miss::outside_model);
}

TEST(DelayPose, SpeedsByPhotodiodesThatStandALittleUnlike) {
  constexpr int kTrials = trials(40), kMostOutside = kTrials / 10 + 1;
  for (const double aside_m : {-0.06, 0.0, 0.06})
    for (const double up_m : {-0.04, 0.0, 0.04}) {
      Site site = two_photodiodes(2.0);
      site.photodiodes[1].position_m[1].mean += aside_m;
      site.photodiodes[1].position_m[2].mean += up_m;
      const Tried found = tried(site, kTrials);
      const auto told = ::testing::Message()
                        << aside_m << " m aside, " << up_m << " m up, sigma " << found.median_share;
      EXPECT_EQ(found.measured, kTrials) << told;
      EXPECT_GE(found.inside, kTrials - kMostOutside) << told;
      EXPECT_LT(found.worst_sigmas, 4.0) << told;
      EXPECT_LT(found.median_share, 0.06) << told;
    }
}

}  // namespace
}  // namespace vildar
