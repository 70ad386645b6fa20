#include "track/vehicle_course.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/random.h"
#include "one_car.h"

namespace vildar {
namespace {

using Road = scene::OneCar;

constexpr double kSpeed_mps = -12.5;  // half a metre in 0.04 s

double along_m(double time_s) { return 70.0 + kSpeed_mps * time_s; }

// A car of 1.2 m between the lamps about y = -4, in frames `first` to `last`.
std::vector<LampLook> looks(const Road& road, std::int64_t first, std::int64_t last) {
  return looks_of(road.lamp(first, last, -3.4).records, road.lamp(first, last, -4.6).records);
}

TEST(VehicleCourse, ComesBackFromItsOwnPlaces) {
  const Road road;
  const auto course = VehicleCourse::of(looks(road, 0, 30), road.view);
  ASSERT_TRUE(course);
  EXPECT_NEAR(course->along_m(0.6), along_m(0.6), 0.5);
  EXPECT_NEAR(course->along_m(2.0), along_m(2.0), 1.0);
  EXPECT_NEAR(course->lateral_m(), -4.0, 0.1);
  EXPECT_LT(course->along_sigma_m(0.6), course->along_sigma_m(2.0));
}

TEST(VehicleCourse, TooLittleTellsNone) {
  const Road road;
  EXPECT_FALSE(VehicleCourse::of(looks(road, 0, 6), road.view));
  const auto alone = looks_of(road.lamp(0, 30, -3.4).records, road.lamp(0, 2, -4.6).records);
  EXPECT_FALSE(VehicleCourse::of(alone, road.view));
  EXPECT_TRUE(VehicleCourse::of(looks(road, 0, 7), road.view));
}

// On a wet road the head that is cut off a clipped area stands above its lamp as long as that is
// far: by elevation the vehicle is 6 m farther away at first, and not at last.
TEST(VehicleCourse, RowsThatWanderHardlyMoveIt) {
  const Road road;
  std::vector<LampLook> seen = looks(road, 0, 30);
  for (std::size_t i = 0; i < seen.size(); ++i)
    for (auto* lamp : {&seen[i].left_px, &seen[i].right_px})
      (*lamp)->y() -= 7.0 * (1.0 - static_cast<double>(i) / 30.0);
  const auto course = VehicleCourse::of(seen, road.view);
  ASSERT_TRUE(course);
  const auto later = course->placed(looks(road, 60, 64), road.view);
  ASSERT_TRUE(later);
  EXPECT_LT(std::abs(course->along_m(2.48) - later->along_m(2.48)), 2.0);

  // The line by elevation alone, in the middle of the lamps.
  Eigen::Vector2d from = Eigen::Vector2d::Zero();
  const auto by_row_m = [&](const LampLook& look) {
    from = 0.5 * (*look.left_px + *look.right_px);
    return road.view.road_at(from, road.view.place(from).inverse_depth_per_m).along_m;
  };
  const double first_m = by_row_m(seen.front()), last_m = by_row_m(seen.back());
  EXPECT_GT(std::abs(last_m + (last_m - first_m) / 1.2 * 1.28 - along_m(2.48)), 5.0);
}

// One look in four is of another light.
TEST(VehicleCourse, StrangeLooksAreLeftOut) {
  const Road road;
  std::vector<LampLook> seen = looks(road, 0, 30);
  Random random(17);
  for (std::size_t i = 0; i < seen.size(); i += 4)
    *seen[i].right_px +=
        Eigen::Vector2d(30.0, 10.0) + 5.0 * Eigen::Vector2d(random.normal(), random.normal());
  const auto course = VehicleCourse::of(seen, road.view);
  ASSERT_TRUE(course);
  EXPECT_NEAR(course->along_m(2.0), along_m(2.0), 1.5);
  EXPECT_NEAR(course->lateral_m(), -4.0, 0.2);
}

// Errors of 1 px in the column and 3 px in the row, each for four frames: off by what sigma says.
TEST(VehicleCourse, SigmaIsTrue) {
  const Road road;
  const std::vector<LampLook> clean = looks(road, 0, 35);
  Random random(5);
  double sum = 0.0;
  constexpr int kTrials = 200;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<LampLook> seen = clean;
    for (std::size_t i = 0; i < seen.size(); i += 4)
      for (auto lamp : {&LampLook::left_px, &LampLook::right_px}) {
        const Eigen::Vector2d off(random.normal(), 3.0 * random.normal());
        for (std::size_t j = i; j < std::min(i + 4, seen.size()); ++j) *(seen[j].*lamp) += off;
      }
    const auto course = VehicleCourse::of(seen, road.view);
    ASSERT_TRUE(course);
    sum += std::pow((course->along_m(2.5) - along_m(2.5)) / course->along_sigma_m(2.5), 2);
  }
  const double ratio = std::sqrt(sum / kTrials);
  EXPECT_GT(ratio, 0.7);
  EXPECT_LT(ratio, 1.4);
}

}  // namespace
}  // namespace vildar
