#include "track/resume.h"

#include <algorithm>
#include <memory>

#include <gtest/gtest.h>

#include "one_car.h"

namespace vildar {
namespace {

using Road = scene::OneCar;

// A car found in frames 42 to 46, shifted from where the lost one would be.
struct Found {
  Lamp left, right;
  Vehicle vehicle;
  Found(const Road& road, double ahead_m, double beside_m)
      : left(road.lamp(42, 46, -3.4 + beside_m, ahead_m)),
        right(road.lamp(42, 46, -4.6 + beside_m, ahead_m)) {
    vehicle.left = &left;
    vehicle.right = &right;
    vehicle.both_seen = 1;
  }
};

Vehicle lost_by(const Road& road, std::int64_t last) {
  Vehicle lost;
  lost.past_left = road.lamp(0, last, -3.4).records;
  lost.past_right = road.lamp(0, last, -4.6).records;
  lost.both_seen = static_cast<int>(last) + 1;
  return lost;
}

TEST(GoesOn, WhereTheLostVehicleWouldBeAndNowhereElse) {
  const Road road;
  const Vehicle lost = lost_by(road, 30);
  EXPECT_TRUE(goes_on(lost, Found(road, 0.0, 0.0).vehicle, road.view));
  EXPECT_TRUE(goes_on(lost, Found(road, 1.0, 0.3).vehicle, road.view));
  // The next one in the lane, one in the next lane, one that was gone before it.
  EXPECT_FALSE(goes_on(lost, Found(road, -8.0, 0.0).vehicle, road.view));
  EXPECT_FALSE(goes_on(lost, Found(road, 8.0, 0.0).vehicle, road.view));
  EXPECT_FALSE(goes_on(lost, Found(road, 0.0, -2.5).vehicle, road.view));
  EXPECT_FALSE(goes_on(lost_by(road, 46), Found(road, 0.0, 0.0).vehicle, road.view));
  // Hardly seen; and tail lamps are another vehicle's.
  EXPECT_FALSE(goes_on(lost_by(road, 5), Found(road, 0.0, 0.0).vehicle, road.view));
  Found red(road, 0.0, 0.0);
  red.vehicle.kind = LampKind::taillamp;
  EXPECT_FALSE(goes_on(lost, red.vehicle, road.view));
}

// A third of a second seen from 70 m, and three seconds later: where it is then is not known.
TEST(GoesOn, NothingIsToldOfWhereItCannotBeKnown) {
  const Road road;
  const auto goes_on_after = [&](std::int64_t frame) {
    Lamp left = road.lamp(frame, frame + 4, -3.4), right = road.lamp(frame, frame + 4, -4.6);
    return goes_on(lost_by(road, 7), scene::vehicle_of(left, right, 1), road.view);
  };
  EXPECT_TRUE(goes_on_after(20));
  EXPECT_FALSE(goes_on_after(90));
}

// Before it was lost its lamps ran together with others, which drew the last looks 20 m on.
TEST(GoesOn, WhereTheLastLooksWereDrawnAside) {
  const Road road;
  Vehicle lost = lost_by(road, 22);
  for (const double y_m : {-3.4, -4.6}) {
    auto& past = y_m > -4.0 ? lost.past_left : lost.past_right;
    const auto drawn = road.lamp(23, 26, y_m, 20.0).records;
    past.insert(past.end(), drawn.begin(), drawn.end());
  }
  EXPECT_TRUE(goes_on(lost, Found(road, 0.0, 0.0).vehicle, road.view));
  EXPECT_FALSE(goes_on(lost, Found(road, 8.0, 0.0).vehicle, road.view));
}

// Frames 20 to 46, and the lost one until 30 in the place of this one, or beside it, where from
// then on the other drives.
TEST(GoesOn, OfTwoSeenTogetherOnlyInOnePlace) {
  const Road road;
  const auto goes_on_from = [&](double beside_m, double ahead_m) {
    const auto y_m = [=](std::int64_t frame) { return -3.4 + (frame <= 30 ? beside_m : 0.0); };
    Lamp left = road.lamp(20, 46, y_m),
         right = road.lamp(20, 46, [&](std::int64_t frame) { return y_m(frame) - 1.2; });
    const Lamp left_ahead = road.lamp(20, 30, y_m, ahead_m),
               right_ahead = road.lamp(
                   20, 30, [&](std::int64_t frame) { return y_m(frame) - 1.2; }, ahead_m);
    std::ranges::copy(left_ahead.records, left.records.begin());
    std::ranges::copy(right_ahead.records, right.records.begin());
    return goes_on(lost_by(road, 30), scene::vehicle_of(left, right), road.view);
  };
  EXPECT_TRUE(goes_on_from(0.0, 0.0));
  EXPECT_TRUE(goes_on_from(-0.4, 1.5));
  EXPECT_FALSE(goes_on_from(-1.0, 0.0));
  EXPECT_FALSE(goes_on_from(0.0, 4.5));
  EXPECT_FALSE(goes_on_from(0.0, -4.5));
}

TEST(Resume, OneTrackWithoutWhatCameAfterTheCut) {
  const Road road;
  Vehicle lost = lost_by(road, 35);
  lost.cut_after = 30;
  lost.came_apart = true;
  Found found(road, 0.0, 0.0);
  ASSERT_TRUE(goes_on(lost, found.vehicle, road.view));
  resume(lost, found.vehicle);
  VehicleTrack track;
  ASSERT_EQ(judge_vehicle(found.vehicle, road.view, {}, {}, track), Verdict::vehicle);
  ASSERT_EQ(track.sightings.size(), 31U + 5U);
  EXPECT_EQ(track.sightings[30].frame, 30);
  EXPECT_EQ(track.sightings[31].frame, 42);
  EXPECT_FALSE(track.ambiguous_identity);
}

// A pair that has been followed for longer is compared with a vehicle that begins to wait, in its
// next frame with both lamps; a new one at once.
TEST(ResumeLost, AskedWhenNewAndWhenOneMoreWaits) {
  const Road road;
  constexpr std::int64_t kFrame = 46;
  struct Case {
    int both_seen;
    std::int64_t asked, last_both;
    bool resumed;
  };
  for (const Case& one :
       {Case{1, -1, kFrame, true}, Case{5, 44, kFrame, false}, Case{5, 43, kFrame, true},
        Case{40, 43, kFrame, true}, Case{40, 43, kFrame - 1, false}, Case{40, 44, kFrame, false}}) {
    Found found(road, 0.0, 0.0);
    Vehicles vehicles, waiting;
    vehicles.push_back(std::make_unique<Vehicle>(found.vehicle));
    Vehicle& pair = *vehicles.front();
    pair.both_seen = one.both_seen;
    pair.asked = one.asked;
    pair.last_both = one.last_both;
    waiting.push_back(std::make_unique<Vehicle>(lost_by(road, 30)));
    constexpr std::int64_t kWaitsSince = 44;
    resume_lost(vehicles, waiting, kFrame, kWaitsSince, road.view);
    EXPECT_EQ(waiting.empty(), one.resumed) << one.both_seen << " " << one.asked;
    EXPECT_EQ(!pair.past_left.empty(), one.resumed);
  }
}

TEST(ResumeLost, OneThatIsStillLookedForIsCutAndOfTwoNoneIsTaken) {
  const Road road;
  constexpr std::int64_t kFrame = 46;
  Found found(road, 0.0, 0.0);
  Vehicles vehicles, waiting;
  vehicles.push_back(std::make_unique<Vehicle>(found.vehicle));
  vehicles.front()->last_both = kFrame;
  vehicles.push_back(std::make_unique<Vehicle>(lost_by(road, 30)));
  vehicles.back()->last_both = 30;
  waiting.push_back(std::make_unique<Vehicle>(lost_by(road, 29)));
  resume_lost(vehicles, waiting, kFrame, 0, road.view);
  EXPECT_EQ(waiting.size(), 1U);
  EXPECT_FALSE(vehicles.back()->cut_after);
  waiting.clear();
  resume_lost(vehicles, waiting, kFrame, 0, road.view);
  EXPECT_EQ(vehicles.back()->cut_after, 30);
  EXPECT_FALSE(vehicles.front()->cut_after);
}

}  // namespace
}  // namespace vildar
