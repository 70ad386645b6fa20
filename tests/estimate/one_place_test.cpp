#include "estimate/one_place.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "core/text.h"
#include "seen_together.h"

namespace vildar {
namespace {

using namespace seen_together;

constexpr double kForever = std::numeric_limits<double>::infinity();
constexpr Vehicle kMotorcycle{.along_m = 70.0, .separation_m = 0.0};

Site curve() {
  Site site = mast_site(5.0);
  site.road.kind = RoadKind::curved;
  site.road.turn = Turn::right;
  site.road.radius_m = Uncertain{60.0, 0.0};
  site.road.straight_m.mean = 10.0;
  return site;
}

TEST(OnePlace, TwoTracksThatTakeTurnsOnOneCarAreOneVehicle) {
  EXPECT_TRUE(one_vehicle(estimate_of(1, kCar, Frames::even), estimate_of(2, kCar, Frames::odd)));
}

// Headlamps and, lower and further in, fog lamps or daytime strips; or the next car's headlamps.
TEST(OnePlace, PairsRightBelowOneAnotherAreOneVehicle) {
  const VehicleEstimate car = estimate_of(1, kCar, Frames::all);
  Vehicle fog_lamps = kCar;
  fog_lamps.height_m -= 0.3;
  fog_lamps.separation_m -= 0.3;
  EXPECT_TRUE(one_vehicle(car, estimate_of(2, fog_lamps, Frames::all)));
  EXPECT_FALSE(one_vehicle(car, estimate_of(3, moved(kCar, 8.0, 0.0), Frames::all)));
  const Site low = mast_site(1.5);
  EXPECT_FALSE(one_vehicle(estimate_of(1, kCar, Frames::all, kLong, low),
                           estimate_of(3, moved(kCar, 8.0, 0.0), Frames::all, kLong, low)));
}

// A caravan's side marker, 4 m ahead of its tail lamps; a motorcycle 12 m ahead, or beside it.
TEST(OnePlace, ALoneLightWithinAVehiclesLengthIsOnItsBody) {
  const VehicleEstimate car = estimate_of(1, kCar, Frames::all);
  Site site = mast_site(5.0);
  site.road.lanes.push_back({"middle", {-5.8, 0.3}, 1.8, Direction::oncoming});
  const auto lone_at = [&](double behind_m, double aside_m) {
    return estimate_of(2, moved(kMotorcycle, behind_m, aside_m), Frames::all, lone(), site);
  };
  EXPECT_TRUE(on_the_body(lone_at(4.0, 1.0), car));
  EXPECT_FALSE(on_the_body(lone_at(12.0, 0.0), car));
  EXPECT_FALSE(on_the_body(lone_at(4.0, -1.8), car));
  EXPECT_FALSE(on_the_body(lone_at(-6.0, 0.0), car));
  EXPECT_FALSE(on_the_body(car, lone_at(4.0, 1.0)));
  EXPECT_FALSE(on_the_body(estimate_of(3, moved(kCar, 4.0, 0.0), Frames::all), car));
}

// The front markers of a caravan, 6 m behind the lamps of the car that draws it; or another car, so
// near, as bright, farther off, beside it or faster.
TEST(OnePlace, AFaintPairAtADrawbarsLengthIsDrawn) {
  const VehicleEstimate car = estimate_of(1, kCar, Frames::all);
  View faint = kLong;
  faint.flux_at_1m *= 0.1;
  const Vehicle behind = moved(kCar, 6.0, 0.0);
  EXPECT_TRUE(on_the_body(estimate_of(2, behind, Frames::all, faint), car));
  EXPECT_FALSE(on_the_body(estimate_of(2, behind, Frames::all), car));
  EXPECT_FALSE(on_the_body(car, estimate_of(2, behind, Frames::all, faint)));
  EXPECT_FALSE(on_the_body(estimate_of(2, moved(kCar, 12.0, 0.0), Frames::all, faint), car));
  EXPECT_FALSE(on_the_body(estimate_of(2, moved(kCar, 6.0, 0.9), Frames::all, faint), car));
  Vehicle comes_nearer = behind;
  comes_nearer.speed_mps += 0.6;
  EXPECT_FALSE(on_the_body(estimate_of(2, comes_nearer, Frames::all, faint), car));
}

// What a camera that smooths over time shows of the frame before, near by.
TEST(OnePlace, FourLampsOfTwoThatWouldBeInOneAnotherAreOneVehicle) {
  const View near{.from_s = 1.6, .to_s = 2.8, .sigma_px = 0.1};
  const VehicleEstimate car = estimate_of(1, kCar, Frames::all);
  EXPECT_TRUE(one_vehicle(car, estimate_of(2, moved(kCar, 0.4, 0.0), Frames::all, near)));
  EXPECT_FALSE(one_vehicle(car, estimate_of(3, moved(kCar, 6.0, 0.0), Frames::all, near)));
}

TEST(OnePlace, ALightOfACarIsTheCar) {
  // One of its lamps, 0.6 m from its middle.
  const Vehicle lamp{.along_m = 70.0, .lateral_m = kCar.lateral_m + 0.6};
  EXPECT_TRUE(
      one_vehicle(estimate_of(1, kCar, Frames::all), estimate_of(2, lamp, Frames::all, lone())));
}

TEST(OnePlace, AFollowerIsAnotherVehicle) {
  const VehicleEstimate car = estimate_of(1, kCar, Frames::even);
  for (const double behind_m : {8.0, 15.0}) {
    const Vehicle behind = moved(kCar, behind_m, 0.0);
    EXPECT_FALSE(one_vehicle(car, estimate_of(2, behind, Frames::odd))) << behind_m;
    EXPECT_FALSE(one_vehicle(car, estimate_of(3, behind, Frames::all, lone()))) << behind_m;
  }
}

TEST(OnePlace, WhatDrivesBesideIsAnotherVehicle) {
  const Vehicle beside = moved(kCar, 0.0, -3.0);
  EXPECT_FALSE(
      one_vehicle(estimate_of(1, kCar, Frames::even), estimate_of(2, beside, Frames::odd)));
  Site site = mast_site(5.0);
  site.road.lanes.push_back({"middle", {-5.8, 0.3}, 1.8, Direction::oncoming});
  const VehicleEstimate first = estimate_of(3, kMotorcycle, Frames::all, lone(), site);
  const VehicleEstimate second =
      estimate_of(4, moved(kMotorcycle, 0.0, -1.8), Frames::all, lone(), site);
  EXPECT_FALSE(one_vehicle(first, second));
  EXPECT_FALSE(one_vehicle(estimate_of(5, kCar, Frames::all), second));
}

TEST(OnePlace, OneThatGoesOnWhereAnotherWasIsTheSame) {
  View early = kLong, late = kLong, much_later = kLong;
  early.to_s = 1.2;
  late.from_s = 1.6;
  much_later.from_s = 2.5;
  much_later.to_s = 3.3;
  const VehicleEstimate car = estimate_of(1, kCar, Frames::all, early);
  EXPECT_TRUE(one_vehicle(car, estimate_of(2, kCar, Frames::all, late)));
  EXPECT_FALSE(one_vehicle(car, estimate_of(3, moved(kCar, 8.0, 0.0), Frames::all, late)));
  EXPECT_TRUE(one_vehicle(car, estimate_of(4, kCar, Frames::all, much_later)));
  EXPECT_FALSE(one_vehicle(car, estimate_of(5, moved(kCar, 8.0, 0.0), Frames::all, much_later)));
}

TEST(OnePlace, HiddenForSecondsAVehicleMayHaveBrakedTooMuchToBeTold) {
  constexpr View kEarly{.to_s = 1.2, .sigma_px = 0.3};
  constexpr View kLate{.from_s = 4.4, .to_s = 5.8, .sigma_px = 0.3};
  const Vehicle far = moved(kCar, 60.0, 0.0);
  EXPECT_FALSE(one_vehicle(estimate_of(1, far, Frames::all, kEarly),
                           estimate_of(2, far, Frames::all, kLate)));
}

TEST(OnePlace, WhereTheFirstWasMustBeKnownToTellThatItGoesOn) {
  // Far off two looks at the car leave open 4 m, room for another one behind it.
  Site site = mast_site(5.0);
  site.lamps.height_m = Uncertain{0.65, 0.3};
  site.lamps.separation_m.reset();
  View early = kLong, late = kLong;
  early.to_s = 0.6;
  late.from_s = 0.8;
  late.to_s = 1.4;
  EXPECT_FALSE(one_vehicle(estimate_of(1, kCar, Frames::all, early, site),
                           estimate_of(2, kCar, Frames::all, late, site)));
}

TEST(OnePlace, HoldsOnASharpCurve) {
  const Site site = curve();
  const Vehicle car{.speed_mps = 12.0, .along_m = 45.0};
  const VehicleEstimate first = estimate_of(1, car, Frames::even, kLong, site);
  EXPECT_TRUE(one_vehicle(first, estimate_of(2, car, Frames::odd, kLong, site)));
  EXPECT_FALSE(one_vehicle(first, estimate_of(3, moved(car, 8.0, 0.0), Frames::odd, kLong, site)));
  EXPECT_FALSE(one_vehicle(first, estimate_of(4, moved(car, 0.0, -3.0), Frames::odd, kLong, site)));
}

// Where the light of a lamp at y = -3.4 is thrown to a camera at y = 0 by a rail at y = -5.6.
constexpr double kRail_m = -5.6, kShare = kRail_m / (2.0 * kRail_m + 3.4);
constexpr Vehicle kPassing{.speed_mps = 24.0, .along_m = 85.0};

Site beside_rail() {
  Site site = mast_site(1.5);
  site.road.lanes[0].lateral_m.std = 1.0;
  return site;
}

VehicleEstimate lone_light(double along_m, double speed_mps, double strength) {
  const Vehicle light{.speed_mps = speed_mps,
                      .along_m = along_m,
                      .lateral_m = kRail_m,
                      .height_m = 0.65,
                      .separation_m = 0.0};
  View view = lone();
  view.flux_at_1m = strength * kLong.flux_at_1m;
  return estimate_of(2, light, Frames::all, view, beside_rail());
}

TEST(OnePlace, ALightThatKeepsAShareOfAPairsDistanceIsItsGlint) {
  const VehicleEstimate car = estimate_of(1, kPassing, Frames::all, kLong, beside_rail());
  const double along_m = kShare * kPassing.along_m, speed_mps = kShare * kPassing.speed_mps;
  EXPECT_TRUE(glints_beside(lone_light(along_m, speed_mps, 0.1), car));
  // A motorcycle as strong, one that comes later, and one as fast are no glints.
  EXPECT_FALSE(glints_beside(lone_light(along_m, speed_mps, 1.0), car));
  EXPECT_FALSE(glints_beside(lone_light(along_m + 5.0, speed_mps, 0.1), car));
  EXPECT_FALSE(glints_beside(lone_light(kPassing.along_m, kPassing.speed_mps, 0.1), car));
}

TEST(MeasuredVehicles, AGlintHasNoSpeed) {
  MeasuredVehicles measured(1.5 - kLampHeight_m, kLampHeight_m);
  measured.add(lone_light(kShare * kPassing.along_m, kShare * kPassing.speed_mps, 0.1));
  measured.add(estimate_of(1, kPassing, Frames::all, kLong, beside_rail()));
  for (const VehicleEstimate& one : measured.take_before(kForever)) {
    EXPECT_EQ(one.result.withheld.has_value(), one.result.track_id == 2);
    if (!one.result.withheld) continue;
    EXPECT_NE(one.result.warnings.back().find("glint of vehicle 1"), std::string::npos);
  }
}

TEST(MeasuredVehicles, OfOneSeenTwiceTheBetterSpeedStands) {
  View brief = kLong;
  brief.to_s = 1.2;
  // Half as many frames, and none from near by: the lesser, in whichever order they end.
  for (const bool lesser_first : {true, false}) {
    MeasuredVehicles measured(kOverLamps_m, kLampHeight_m);
    const auto lesser = [&] { return estimate_of(1, kCar, Frames::odd, brief); };
    if (lesser_first) measured.add(lesser());
    measured.add(estimate_of(2, kCar, Frames::even));
    if (!lesser_first) measured.add(lesser());
    const auto both = measured.take_before(kForever);
    ASSERT_EQ(both.size(), 2U);
    for (const VehicleEstimate& one : both) {
      if (one.result.track_id == 2) {
        EXPECT_FALSE(one.result.withheld);
        continue;
      }
      EXPECT_EQ(one.result.withheld, Miss::ambiguous_identity);
      EXPECT_FALSE(one.result.range_ref_m);
      EXPECT_TRUE(std::ranges::none_of(
          one.rows, [](const TrackRow& row) { return row.range_m.has_value(); }));
      EXPECT_TRUE(std::ranges::none_of(one.result.methods, [](const MethodResult& method) {
        return method.method == Method::geometry_camera &&
               std::holds_alternative<SpeedEstimate>(method.speed);
      }));
      ASSERT_FALSE(one.result.warnings.empty());
      EXPECT_NE(one.result.warnings.back().find("vehicle 2"), std::string::npos);
    }
  }
}

// A low trailer over which the tail lamps of the car that draws it are seen, 5 m ahead; or another
// car, at 9 m, in the next lane, or faster.
TEST(MeasuredVehicles, OfACarAndItsTrailerTheBetterSpeedStands) {
  Vehicle next_lane = moved(kCar, 5.0, 1.8), faster = moved(kCar, 5.0, 0.0);
  faster.speed_mps *= 1.25;
  const std::pair<Vehicle, bool> others[] = {{moved(kCar, 5.0, 0.0), true},
                                             {moved(kCar, -5.0, 0.2), true},
                                             {moved(kCar, 9.0, 0.0), false},
                                             {next_lane, false},
                                             {faster, false}};
  Site bend = mast_site(5.0);
  bend.road.kind = RoadKind::curved;
  bend.road.radius_m = Uncertain{70.0, 3.0};
  bend.road.turn = Turn::left;
  bend.camera->yaw_rad.mean = 0.3;
  for (const Site& site : {mast_site(5.0), bend})
    for (const auto& [other, drawn] : others) {
      MeasuredVehicles measured(kOverLamps_m, kLampHeight_m);
      measured.add(estimate_of(1, kCar, Frames::all, kLong, site));
      measured.add(estimate_of(2, other, Frames::odd, kLong, site));
      const auto both = measured.take_before(kForever);
      ASSERT_EQ(both.size(), 2U);
      EXPECT_EQ(both[0].result.withheld.has_value() + both[1].result.withheld.has_value(), drawn)
          << other.along_m;
    }
}

// Fog lamps that were seen for longer: fainter, as bright as the headlamps, or brighter by far.
TEST(MeasuredVehicles, OfLampsOnOneFrontTheHeadlampsTellTheSpeed) {
  Vehicle lower = kCar;
  lower.height_m -= 0.3;
  View brief = kLong;
  brief.from_s = 0.6;
  for (const double strength : {0.1, 0.8, 5.0}) {
    View view = kLong;
    view.flux_at_1m *= strength;
    MeasuredVehicles measured(kOverLamps_m, kLampHeight_m);
    measured.add(estimate_of(1, lower, Frames::all, view));
    measured.add(estimate_of(2, kCar, Frames::all, brief));
    const auto both = measured.take_before(kForever);
    ASSERT_EQ(both.size(), 2U);
    for (const VehicleEstimate& one : both)
      EXPECT_EQ(one.result.withheld.has_value(), one.result.track_id == (strength > 1.0 ? 2 : 1))
          << one.result.track_id << ", " << strength;
  }
}

TEST(MeasuredVehicles, LampsOnARoofHaveNoSpeed) {
  for (const bool roof_first : {true, false}) {
    MeasuredVehicles measured(kOverLamps_m, kLampHeight_m);
    const auto roof = [&] { return estimate_of(1, roof_lamps(2.5, 1.0), Frames::all); };
    if (roof_first) measured.add(roof());
    measured.add(estimate_of(2, kCar, Frames::all));
    if (!roof_first) measured.add(roof());
    for (const VehicleEstimate& one : measured.take_before(kForever))
      EXPECT_EQ(one.result.withheld.has_value(), one.result.track_id == 1) << one.result.track_id;
  }
}

TEST(MeasuredVehicles, ALoneLightBelowAPairIsNoMoreAVehicleThanThePair) {
  MeasuredVehicles measured(kOverLamps_m, kLampHeight_m);
  measured.add(estimate_of(1, roof_lamps(2.5, 1.0), Frames::all));
  measured.add(estimate_of(2, kMotorcycle, Frames::all, lone()));
  const auto taken = measured.take_before(kForever);
  ASSERT_EQ(taken.size(), 2U);
  for (const VehicleEstimate& one : taken)
    EXPECT_EQ(one.result.withheld, Miss::ambiguous_identity) << one.result.track_id;
}

TEST(MeasuredVehicles, AreHeldUntilNoneThatWasInViewWithThemIsMissing) {
  MeasuredVehicles measured(kOverLamps_m, kLampHeight_m);
  measured.add(estimate_of(1, kCar, Frames::all));
  // Last seen at 2.8 s; another that is first seen 3.5 s later may be the same.
  EXPECT_TRUE(measured.take_before(6.2).empty());
  EXPECT_EQ(measured.take_before(6.4).size(), 1U);
  EXPECT_TRUE(measured.take_before(kForever).empty());
}

}  // namespace
}  // namespace vildar
