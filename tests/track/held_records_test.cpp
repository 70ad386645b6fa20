#include "track/held_records.h"

#include <gtest/gtest.h>

#include "one_car.h"
#include "track/vehicle.h"

namespace vildar {
namespace {

constexpr std::size_t kMany = 5000, kKept = 2000;

/// A pair of lamps, seen again and again where it was last seen.
struct Pair {
  scene::OneCar road;
  Lamps lamps;
  Vehicles vehicles;

  explicit Pair(std::int64_t moving_frames) {
    for (const double y_m : {-3.4, -4.6}) {
      lamps.push_back(std::make_unique<Lamp>(road.lamp(0, moving_frames, y_m)));
      std::vector<LampRecord>& records = lamps.back()->records;
      records.resize(kMany, records.back());
    }
    vehicles.push_back(std::make_unique<Vehicle>());
    vehicles.front()->left = lamps[0].get();
    vehicles.front()->right = lamps[1].get();
  }
  void pair_up() {
    for (const auto& lamp : lamps) lamp->vehicle = vehicles.front().get();
  }
};

TEST(HeldRecords, APairThatNeverMovedKeepsTheLast) {
  Pair parked(1);
  parked.pair_up();
  parked.vehicles.front()->past_left.resize(10, parked.lamps[0]->records.front());
  drop_old_records(parked.lamps, parked.vehicles);
  for (const auto& lamp : parked.lamps) EXPECT_EQ(lamp->records.size(), kKept);
  EXPECT_TRUE(parked.vehicles.front()->past_left.empty());
}

TEST(HeldRecords, NothingIsLostOfOneThatDrove) {
  Pair driven(30);
  driven.pair_up();
  drop_old_records(driven.lamps, driven.vehicles);
  for (const auto& lamp : driven.lamps) EXPECT_EQ(lamp->records.size(), kMany);
}

TEST(HeldRecords, OfLightsWithoutAPartnerTheLastAreKept) {
  Pair apart(30);
  apart.vehicles.clear();
  apart.lamps[0]->fixed = true;
  drop_old_records(apart.lamps, apart.vehicles);
  EXPECT_EQ(apart.lamps[0]->records.size(), 100U);
  EXPECT_EQ(apart.lamps[1]->records.size(), kKept);
}

}  // namespace
}  // namespace vildar
