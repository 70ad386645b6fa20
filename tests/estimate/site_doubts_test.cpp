#include "estimate/site_doubts.h"

#include <vector>

#include <gtest/gtest.h>

#include "estimate/vehicle.h"
#include "simulated_pass.h"

namespace vildar {
namespace {

using Results = std::vector<VehicleResult>;

Results driving(int count) {
  Results vehicles(static_cast<std::size_t>(count));
  for (VehicleResult& vehicle : vehicles) {
    vehicle.used_camera = true;
    vehicle.n_frames = 50;
    vehicle.speed.speed_mps = 15.0;
    vehicle.speed.std_mps = 0.5;
    vehicle.lane = "near";
  }
  return vehicles;
}

TEST(SiteDoubts, MostInNoLaneDoubtTheLanes) {
  RoadSite road = simulated::mast_site(4.0).road;
  Results vehicles = driving(3);
  vehicles[0].no_lane_probability = 0.9;
  EXPECT_TRUE(site_doubts(vehicles, road).empty());
  // Which of two lanes it is may be open.
  vehicles[1].lane = "";
  vehicles[1].no_lane_probability = 0.2;
  EXPECT_TRUE(site_doubts(vehicles, road).empty());
  vehicles[1].no_lane_probability = 0.9;
  // Of those that drive away no lane is told.
  vehicles[1].direction = Direction::receding;
  EXPECT_TRUE(site_doubts(vehicles, road).empty());
  vehicles[1].direction = Direction::oncoming;
  const auto doubts = site_doubts(vehicles, road);
  ASSERT_EQ(doubts.size(), 1U);
  EXPECT_NE(doubts[0].find("2 of 3 vehicles drive in none of the lanes"), std::string::npos)
      << doubts[0];
  vehicles[1].speed.speed_mps = 0.2;  // parked
  EXPECT_TRUE(site_doubts(vehicles, road).empty());
  road.lanes.clear();
  vehicles[1].speed.speed_mps = 15.0;
  EXPECT_TRUE(site_doubts(vehicles, road).empty());
}

TEST(SiteDoubts, MostThatMoveOtherwiseDoubtCameraAndRoad) {
  Results vehicles = driving(5);
  vehicles[0].withheld = Miss::not_on_road;
  vehicles[1].withheld = Miss::bad_fit;
  EXPECT_TRUE(site_doubts(vehicles, {}).empty());
  vehicles[2].withheld = Miss::unobservable;
  const auto doubts = site_doubts(vehicles, {});
  ASSERT_EQ(doubts.size(), 1U);
  EXPECT_NE(doubts[0].find("3 of 5 vehicles do not move as on the road stated"), std::string::npos)
      << doubts[0];
  // By light alone nothing is said of a camera.
  for (VehicleResult& vehicle : vehicles) vehicle.n_frames = 0;
  EXPECT_TRUE(site_doubts(vehicles, {}).empty());
  for (VehicleResult& vehicle : vehicles) vehicle.n_frames = 50;
  vehicles[2].withheld = Miss::too_short;
  EXPECT_TRUE(site_doubts(vehicles, {}).empty());
}

TEST(SiteDoubts, LightsThatGoAlongWithVehiclesSpeakForNoOtherSite) {
  Results vehicles = driving(5);
  for (VehicleResult& vehicle : vehicles) vehicle.t_last_s = 4.0;
  for (std::size_t i = 1; i < 5; ++i) vehicles[i].withheld = Miss::not_on_road;
  EXPECT_FALSE(most_elsewhere(vehicles));
  // They go another way, or are there at another time.
  for (std::size_t i = 1; i < 3; ++i) vehicles[i].direction = Direction::receding;
  for (std::size_t i = 3; i < 5; ++i) vehicles[i].t_last_s = 10.0;
  auto elsewhere = most_elsewhere(vehicles);
  ASSERT_TRUE(elsewhere);
  EXPECT_EQ(elsewhere->count, 4);
  EXPECT_EQ(elsewhere->of, 5);
  vehicles[3].withheld = vehicles[4].withheld = Miss::too_short;
  EXPECT_FALSE(most_elsewhere(vehicles));
  // Lamps that no road explains are those of vehicles.
  for (std::size_t i = 1; i < 4; ++i) vehicles[i] = vehicles[0];
  for (std::size_t i = 1; i < 4; ++i) vehicles[i].withheld = Miss::bad_fit;
  elsewhere = most_elsewhere(vehicles);
  ASSERT_TRUE(elsewhere);
  EXPECT_EQ(elsewhere->count, 3);
}

// Seen by a camera at a stop line: the ones brake, the others start.
Results at_a_stop_line(double oncoming_mps2, double receding_mps2) {
  const Site site = simulated::mast_site(4.0);
  Results vehicles;
  Random random(9);
  for (int i = 0; i < 4; ++i) {
    simulated::Vehicle comes{.speed_mps = 15.0, .acceleration_mps2 = oncoming_mps2};
    vehicles.push_back(
        estimate_vehicle(simulated::track_of(comes, site, {}, random), site, {}).result);
    simulated::Vehicle goes{.speed_mps = -10.0, .acceleration_mps2 = -receding_mps2};
    goes.along_m = 12.0;
    VehicleTrack track = simulated::track_of(goes, site, {}, random);
    track.direction = Direction::receding;
    track.kind = LampKind::taillamp;
    Site tails = site;
    tails.road.lanes[0].direction = Direction::receding;
    tails.lamps.tail_height_m = site.lamps.height_m;
    tails.lamps.tail_separation_m = site.lamps.separation_m;
    vehicles.push_back(estimate_vehicle(track, tails, {}).result);
  }
  for (const VehicleResult& vehicle : vehicles) EXPECT_FALSE(vehicle.withheld);
  return vehicles;
}

TEST(SiteDoubts, EachDirectionSpeedsUpOrBrakesByItself) {
  const auto doubts = site_doubts(at_a_stop_line(-2.5, 2.5), {});
  ASSERT_EQ(doubts.size(), 2U);
  EXPECT_NE(doubts[0].find("4 oncoming vehicles seem to brake by 2."), std::string::npos)
      << doubts[0];
  EXPECT_NE(doubts[1].find("4 receding vehicles seem to speed up by 2."), std::string::npos)
      << doubts[1];
  EXPECT_TRUE(site_doubts(at_a_stop_line(0.0, 0.0), {}).empty());
}

}  // namespace
}  // namespace vildar
