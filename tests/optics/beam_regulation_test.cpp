// The parametric beams against the test points of the UN regulations, angles in degrees: left
// positive as everywhere in this project, up positive.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/quantity.h"
#include "optics/lamp_beam.h"
#include "toward.h"

namespace vildar {
namespace {

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

struct TestPoint {
  std::string name;
  double left_deg, up_deg;
  double least_cd, most_cd;
};

void expect_within(const LampBeam& beam, const std::vector<TestPoint>& points) {
  for (const TestPoint& point : points) {
    const double intensity_cd = toward(beam, point.left_deg, point.up_deg);
    EXPECT_GE(intensity_cd, point.least_cd) << point.name;
    EXPECT_LE(intensity_cd, point.most_cd) << point.name;
    ::testing::Test::RecordProperty(point.name, std::to_string(intensity_cd) + " cd");
  }
}

TEST(LowBeamR112, KeepsEveryTestPointOfClassB) {
  expect_within(LampBeam{LowBeam{}}, {
                                         {"B50L", 3.43, 0.57, 0.0, 350.0},
                                         {"75R", -1.15, -0.57, 10'100.0, kNoLimit},
                                         {"75L", 3.43, -0.57, 0.0, 10'600.0},
                                         {"50L", 3.43, -0.86, 0.0, 13'200.0},
                                         {"50R", -1.72, -0.86, 10'100.0, kNoLimit},
                                         {"50V", 0.0, -0.86, 5'100.0, kNoLimit},
                                         {"25L", 9.0, -1.72, 1'700.0, kNoLimit},
                                         {"25R", -9.0, -1.72, 1'700.0, kNoLimit},
                                     });
}

struct Corner {
  double left_deg, up_deg;
};

/// Even-odd rule.
bool inside(const std::vector<Corner>& polygon, double left_deg, double up_deg) {
  bool is_inside = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const Corner &a = polygon[i], &b = polygon[j];
    if ((a.up_deg > up_deg) != (b.up_deg > up_deg) &&
        left_deg <
            (b.left_deg - a.left_deg) * (up_deg - a.up_deg) / (b.up_deg - a.up_deg) + a.left_deg)
      is_inside = !is_inside;
  }
  return is_inside;
}

TEST(LowBeamR112, KeepsItsZones) {
  constexpr double kStep_deg = 0.05;
  const std::vector<Corner> zone_3{{8.0, 1.0},  {8.0, 4.0},  {-8.0, 4.0}, {-8.0, 2.0},
                                   {-6.0, 1.5}, {-1.5, 1.5}, {0.0, 0.0},  {4.0, 0.0}};
  const LampBeam beam{LowBeam{}};
  double most_3_cd = 0.0, most_1_cd = 0.0, least_4_cd = kNoLimit;
  for (const Corner& corner : zone_3)
    most_3_cd = std::max(most_3_cd, toward(beam, corner.left_deg, corner.up_deg));
  for (int i = -180; i <= 180; ++i)
    for (int j = -80; j <= 80; ++j) {
      const double left_deg = kStep_deg * i, up_deg = kStep_deg * j;
      const double intensity_cd = toward(beam, left_deg, up_deg);
      if (inside(zone_3, left_deg, up_deg)) most_3_cd = std::max(most_3_cd, intensity_cd);
      if (up_deg >= -4.0 && up_deg <= -1.72) most_1_cd = std::max(most_1_cd, intensity_cd);
      if (std::abs(left_deg) <= 5.15 && up_deg <= -0.85 && up_deg >= -1.75)
        least_4_cd = std::min(least_4_cd, intensity_cd);
    }
  EXPECT_LE(most_3_cd, 625.0);
  EXPECT_LE(most_1_cd, 17'600.0);
  EXPECT_LE(most_1_cd, 2.0 * toward(beam, -1.72, -0.86));
  EXPECT_GE(least_4_cd, 2'500.0);
}

TEST(LowBeamR112, ItsCutOffIsSharpEnoughAndLiesOnePerCentDown) {
  const LampBeam beam{LowBeam{}};
  double sharpest = 0.0, sharpest_up_deg = 0.0;
  for (double up_deg = -2.0; up_deg < 1.0; up_deg += 0.01) {
    const double sharpness =
        std::log10(toward(beam, 2.5, up_deg) / toward(beam, 2.5, up_deg + 0.1));
    if (sharpness <= sharpest) continue;
    sharpest = sharpness;
    sharpest_up_deg = up_deg + 0.05;
  }
  EXPECT_GE(sharpest, 0.13);
  EXPECT_LE(sharpest, 0.40);
  EXPECT_NEAR(sharpest_up_deg, -0.57, 0.05);
}

TEST(HighBeamR112, IsBrightEnoughAheadAndAside) {
  const LampBeam beam{HighBeam{}};
  double most_cd = 0.0;
  for (double left_deg = -6.0; left_deg <= 6.0; left_deg += 0.1)
    for (double up_deg = -4.0; up_deg <= 4.0; up_deg += 0.1)
      most_cd = std::max(most_cd, toward(beam, left_deg, up_deg));
  EXPECT_GE(most_cd, 40'500.0);
  EXPECT_LE(most_cd, 215'000.0);
  EXPECT_GE(toward(beam, 0.0, 0.0), 0.8 * most_cd);
  expect_within(beam, {{"H-2.6L", 2.6, 0.0, 20'300.0, kNoLimit},
                       {"H-2.6R", -2.6, 0.0, 20'300.0, kNoLimit},
                       {"H-5.2L", 5.2, 0.0, 5'100.0, kNoLimit},
                       {"H-5.2R", -5.2, 0.0, 5'100.0, kNoLimit}});
}

/// Least shares of the axis' minimum in the standard light distribution of signal lamps.
struct GridPoint {
  double left_deg, up_deg, share;
};
constexpr std::array kStandardDistribution{
    GridPoint{0.0, 0.0, 1.0},   GridPoint{5.0, 0.0, 0.9},  GridPoint{10.0, 0.0, 0.7},
    GridPoint{20.0, 0.0, 0.25}, GridPoint{0.0, 5.0, 0.7},  GridPoint{10.0, 5.0, 0.2},
    GridPoint{20.0, 5.0, 0.1},  GridPoint{5.0, 10.0, 0.2},
};

void expect_signal(const SignalBeam& shape, double least_axis_cd, double most_cd,
                   double field_left_deg, double field_up_deg, double least_field_cd) {
  const LampBeam beam{shape};
  for (const GridPoint& point : kStandardDistribution)
    for (const double side : {-1.0, 1.0})
      for (const double height : {-1.0, 1.0})
        EXPECT_GE(toward(beam, side * point.left_deg, height * point.up_deg),
                  least_axis_cd * point.share)
            << point.left_deg << ", " << point.up_deg;
  for (double left_deg = -field_left_deg; left_deg <= field_left_deg; left_deg += 1.0)
    for (double up_deg = -field_up_deg; up_deg <= field_up_deg; up_deg += 1.0) {
      EXPECT_GE(toward(beam, left_deg, up_deg), least_field_cd) << left_deg << ", " << up_deg;
      EXPECT_LE(toward(beam, left_deg, up_deg), most_cd) << left_deg << ", " << up_deg;
    }
}

TEST(SignalLamps, DaytimeRunningLampsKeepR87) {
  expect_signal(kDaytimeRunningLamp, 400.0, 1200.0, 20.0, 10.0, 1.0);
}

TEST(SignalLamps, TailLampsKeepR7) { expect_signal(kTailLamp, 4.0, 17.0, 80.0, 15.0, 0.05); }

}  // namespace
}  // namespace vildar
