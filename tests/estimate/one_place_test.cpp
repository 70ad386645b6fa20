#include "estimate/one_place.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "simulated_pass.h"

namespace vildar {
namespace {

using simulated::mast_site;
using simulated::track_of;
using simulated::Vehicle;
using simulated::View;

constexpr double kForever = std::numeric_limits<double>::infinity();
constexpr Vehicle kCar{.along_m = 70.0};
constexpr Vehicle kMotorcycle{.along_m = 70.0, .separation_m = 0.0};
constexpr View kLong{.to_s = 2.8, .sigma_px = 0.3};

enum class Frames { all, even, odd };

VehicleEstimate estimate_of(int id, const Vehicle& vehicle, Frames frames, const View& view = kLong,
                            const Site& site = mast_site(5.0)) {
  Random random(static_cast<std::uint64_t>(id));
  VehicleTrack track = track_of(vehicle, site, view, random);
  track.id = id;
  for (VehicleSighting& one : track.sightings)
    one.frame += std::lround(view.from_s * view.frame_rate_hz);
  std::erase_if(track.sightings, [&](const VehicleSighting& one) {
    return frames != Frames::all && one.frame % 2 != (frames == Frames::odd);
  });
  VehicleEstimate estimate = estimate_vehicle(track, site, {});
  EXPECT_FALSE(estimate.result.withheld) << name_of(*estimate.result.withheld);
  return estimate;
}

Vehicle moved(Vehicle vehicle, double along_m, double lateral_m) {
  vehicle.along_m += along_m;
  vehicle.lateral_m += lateral_m;
  return vehicle;
}

View lone() {
  View view = kLong;
  view.single_lamp = true;
  return view;
}

Site curve() {
  Site site = mast_site(5.0);
  site.road.kind = RoadKind::curved;
  site.road.turn = Turn::right;
  site.road.radius_m = Uncertain{60.0, 0.0};
  site.road.straight_m = 10.0;
  return site;
}

TEST(OnePlace, TwoTracksThatTakeTurnsOnOneCarAreOneVehicle) {
  EXPECT_TRUE(one_vehicle(estimate_of(1, kCar, Frames::even), estimate_of(2, kCar, Frames::odd)));
}

TEST(OnePlace, FourLampsAtOnceAreTwoVehicles) {
  EXPECT_FALSE(one_vehicle(estimate_of(1, kCar, Frames::all), estimate_of(2, kCar, Frames::all)));
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
  much_later.from_s = 2.3;
  const VehicleEstimate car = estimate_of(1, kCar, Frames::all, early);
  EXPECT_TRUE(one_vehicle(car, estimate_of(2, kCar, Frames::all, late)));
  EXPECT_FALSE(one_vehicle(car, estimate_of(3, moved(kCar, 8.0, 0.0), Frames::all, late)));
  EXPECT_FALSE(one_vehicle(car, estimate_of(4, kCar, Frames::all, much_later)));
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

TEST(MeasuredVehicles, OfOneSeenTwiceTheBetterSpeedStands) {
  View brief = kLong;
  brief.to_s = 1.2;
  // Half as many frames, and none from near by: the lesser, in whichever order they end.
  for (const bool lesser_first : {true, false}) {
    MeasuredVehicles measured;
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

TEST(MeasuredVehicles, AreHeldUntilNoneThatWasInViewWithThemIsMissing) {
  MeasuredVehicles measured;
  measured.add(estimate_of(1, kCar, Frames::all));
  // Last seen at 2.8 s; another that is first seen a second later may be the same.
  EXPECT_TRUE(measured.take_before(3.7).empty());
  EXPECT_EQ(measured.take_before(3.9).size(), 1U);
  EXPECT_TRUE(measured.take_before(kForever).empty());
}

}  // namespace
}  // namespace vildar
