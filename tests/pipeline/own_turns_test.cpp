#include "pipelines/own_turns.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

namespace vildar {
namespace {

constexpr double kEnd_s = 30.0;

template <class YawRate>
Site site_of(const YawRate& yaw_rate_rad_per_s, double speed_mps = 15.0) {
  Site site;
  site.file = "site.yaml";
  site.ego.emplace();
  for (double t_s = 0.0; t_s <= kEnd_s; t_s += 0.1)
    site.ego->trace.push_back({t_s, speed_mps, yaw_rate_rad_per_s(t_s)});
  return site;
}

TEST(OwnTurns, ABendThatTheRoadStatedDoesNotHaveIsTold) {
  // 90 degrees to the right in 8 s: 15 m/s * 8 s / (pi / 2) = 76 m.
  Site site =
      site_of([](double t_s) { return t_s > 10.0 && t_s < 18.0 ? -std::numbers::pi / 16.0 : 0.0; });
  const auto straight = turns_off_the_road(site, kEnd_s);
  ASSERT_EQ(straight.size(), 1U);
  EXPECT_NE(straight[0].find("from 10.0 to 18.0 s"), std::string::npos) << straight[0];
  EXPECT_NE(straight[0].find("turn: right, radius_m: 76 "), std::string::npos) << straight[0];
  EXPECT_TRUE(turns_off_the_road(site, 9.0).empty());
}

TEST(OwnTurns, TheRoadStatedIsFollowed) {
  Site site = site_of([](double) { return 0.15; });
  site.road.kind = RoadKind::curved;
  site.road.radius_m = Uncertain{100.0, 0.0};
  site.road.turn = Turn::left;
  EXPECT_TRUE(turns_off_the_road(site, kEnd_s).empty());
  site.road.turn = Turn::right;
  EXPECT_EQ(turns_off_the_road(site, kEnd_s).size(), 1U);
}

TEST(OwnTurns, ALooselyKnownRadiusIsAllowedFor) {
  Site site = site_of([](double) { return 15.0 / 210.0; });
  site.road.kind = RoadKind::curved;
  site.road.radius_m = Uncertain{400.0, 150.0};
  EXPECT_TRUE(turns_off_the_road(site, kEnd_s).empty());
  site.road.radius_m->std = 10.0;
  const auto told = turns_off_the_road(site, kEnd_s);
  ASSERT_EQ(told.size(), 1U);
  EXPECT_NE(told[0].find("turn: left, radius_m: 210 "), std::string::npos) << told[0];
}

// The last yaw rate does not hold after the trace: it ends in the middle of a change of lanes.
TEST(OwnTurns, BeyondTheTraceNothingIsTold) {
  Site site = site_of([](double t_s) { return t_s > 2.0 ? 0.09 : 0.0; });
  std::erase_if(site.ego->trace, [](const EgoSample& sample) { return sample.time_s > 3.0; });
  EXPECT_TRUE(turns_off_the_road(site, kEnd_s).empty());
}

TEST(OwnTurns, YawRatesOfTheOtherSignAreNamedAsThat) {
  Site site = site_of([](double) { return -0.15; });
  site.road.kind = RoadKind::curved;
  site.road.radius_m = Uncertain{100.0, 0.0};
  const auto told = turns_off_the_road(site, kEnd_s);
  ASSERT_EQ(told.size(), 1U);
  EXPECT_NE(told[0].find("check the sign of the yaw rates"), std::string::npos) << told[0];
}

// Its straight ends are within the 8 s, too.
TEST(OwnTurns, TheRadiusIsThatOfTheTurn) {
  const Site site = site_of([](double t_s) { return t_s > 10.0 && t_s < 13.0 ? 0.5 : 0.0; }, 5.0);
  const auto told = turns_off_the_road(site, kEnd_s);
  ASSERT_EQ(told.size(), 1U);
  const std::size_t at = told[0].find("radius_m: ");
  ASSERT_NE(at, std::string::npos) << told[0];
  EXPECT_EQ(told[0].substr(at + 10, 3), "10 ") << told[0];
}

// It stands or creeps for 3 s before a bend of 60 m, and its yaw rate is never quite nought.
TEST(OwnTurns, TheNoiseOfOneThatStandsOrCreepsIsNoTurn) {
  for (const double creeping_mps : {0.0, 0.5, 2.0}) {
    Site site = site_of([](double t_s) { return t_s > 13.0 ? 15.0 / 60.0 : 0.0; });
    for (EgoSample& sample : site.ego->trace) {
      if (sample.time_s < 10.0 || sample.time_s > 13.0) continue;
      sample.speed_mps = creeping_mps;
      sample.yaw_rate_rad_per_s = 0.02;
    }
    const auto told = turns_off_the_road(site, kEnd_s);
    ASSERT_EQ(told.size(), 1U) << creeping_mps;
    EXPECT_NE(told[0].find("radius_m: 60 "), std::string::npos) << told[0];
  }
}

// Half a degree per second, written as it is, passes for what tyres give.
TEST(OwnTurns, DegreesPerSecondAreAskedAfter) {
  const auto told = turns_off_the_road(site_of([](double) { return 0.5; }), kEnd_s);
  ASSERT_EQ(told.size(), 1U);
  EXPECT_NE(told[0].find("30 m of radius at 15 m/s"), std::string::npos) << told[0];
  EXPECT_NE(told[0].find("degrees times 0.01745"), std::string::npos) << told[0];
}

// By 3.5 m within 60 and 20 m, beside a sensor that is off by 0.3 degrees/s all the while.
TEST(OwnTurns, ChangingLanesWithADriftingSensorKeepsToTheRoad) {
  constexpr double kChange_m = 3.5, kPi = std::numbers::pi;
  for (const auto& [speed_mps, change_s] : {std::pair{15.0, 4.0}, std::pair{5.0, 4.0}}) {
    // Heading 2 d / (v T) sin^2(pi t / T): beside by d in the end.
    const double yaw_rate = 2.0 * kPi * kChange_m / (speed_mps * change_s * change_s);
    const auto yaw_rate_at = [&](double t_s) {
      const bool changes = t_s > 5.0 && t_s < 5.0 + change_s;
      return 0.0053 + (changes ? yaw_rate * std::sin(2.0 * kPi * (t_s - 5.0) / change_s) : 0.0);
    };
    EXPECT_TRUE(turns_off_the_road(site_of(yaw_rate_at, speed_mps), kEnd_s).empty()) << speed_mps;
  }
  EXPECT_TRUE(turns_off_the_road(site_of([](double) { return 0.0; }), kEnd_s).empty());
}

}  // namespace
}  // namespace vildar
