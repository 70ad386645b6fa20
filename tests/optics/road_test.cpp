#include "optics/road.h"

#include <gtest/gtest.h>

#include "core/quantity.h"
#include "core/random.h"

namespace vildar {
namespace {

RoadSite road_of(RoadKind kind, Turn turn, double straight_m, double radius_m) {
  RoadSite road;
  road.kind = kind;
  road.turn = turn;
  road.straight_m.mean = straight_m;
  road.radius_m = Uncertain{radius_m, 0.0};
  return road;
}

PathPoint<double> point_of(const RoadSite& road, double along_m, double lateral_m) {
  return path_point(along_m, lateral_m, bend_of(road), road.straight_m.mean, road.radius_m->mean);
}

const std::vector<RoadSite> kRoads{road_of(RoadKind::straight, Turn::left, 0.0, 40.0),
                                   road_of(RoadKind::curved, Turn::left, 12.0, 40.0),
                                   road_of(RoadKind::curved, Turn::right, 12.0, 40.0),
                                   road_of(RoadKind::curved, Turn::right, 0.0, 15.0)};

TEST(Road, AVehicleOnTheArcStandsWhereThePaperPutsIt) {
  // R_o = d_o = 0: x = r_c sin(beta), |y| = r_c (1 - cos(beta)).
  for (const Turn turn : {Turn::left, Turn::right}) {
    const RoadSite road = road_of(RoadKind::curved, turn, 0.0, 40.0);
    for (const double beta_deg : {0.0, 10.0, 45.0, 90.0}) {
      const double beta_rad = radians_from_degrees(beta_deg);
      const auto point = point_of(road, 40.0 * beta_rad, 0.0);
      EXPECT_NEAR(point.x_m, 40.0 * std::sin(beta_rad), 1e-12);
      EXPECT_NEAR(point.y_m, bend_of(road) * 40.0 * (1.0 - std::cos(beta_rad)), 1e-12);
      EXPECT_NEAR(point.heading_rad, bend_of(road) * beta_rad, 1e-12);
    }
  }
}

TEST(Road, LanesAreConcentricWithTheirOwnRadius) {
  // A left bend of radius 40 has its centre at (12, 40); a lane at +4 runs 36 m from it.
  const auto left = point_of(kRoads[1], 12.0 + 30.0, 4.0);
  EXPECT_NEAR(std::hypot(left.x_m - 12.0, left.y_m - 40.0), 36.0, 1e-12);
  EXPECT_NEAR(left.heading_rad, 30.0 / 36.0, 1e-12);
  // A right bend has its centre at (12, -40); the same lane runs 44 m from it.
  const auto right = point_of(kRoads[2], 12.0 + 30.0, 4.0);
  EXPECT_NEAR(std::hypot(right.x_m - 12.0, right.y_m + 40.0), 44.0, 1e-12);
  EXPECT_NEAR(right.heading_rad, -30.0 / 44.0, 1e-12);
}

TEST(Road, AMetreAlongThePathIsAMetreOverTheGroundTowardsItsHeading) {
  constexpr double kStep_m = 1e-4;
  constexpr double kTolerance =
      1e-7;  // central difference: the step squared over the radius squared
  for (const RoadSite& road : kRoads) {
    for (double along_m = -5.0; along_m < 60.0; along_m += 0.77) {
      const auto before = point_of(road, along_m - kStep_m, -3.0);
      const auto after = point_of(road, along_m + kStep_m, -3.0);
      const auto here = point_of(road, along_m, -3.0);
      EXPECT_NEAR((after.x_m - before.x_m) / (2.0 * kStep_m), std::cos(here.heading_rad),
                  kTolerance);
      EXPECT_NEAR((after.y_m - before.y_m) / (2.0 * kStep_m), std::sin(here.heading_rad),
                  kTolerance);
    }
  }
}

TEST(Road, PositionInvertsThePath) {
  constexpr double kTolerance_m = 1e-10;
  Random random(31);
  for (const RoadSite& road : kRoads) {
    for (int trial = 0; trial < 500; ++trial) {
      const double lateral_m = random.uniform(-8.0, 8.0);
      // Up to a third of a circle, which is past where x begins to shrink again.
      const double lane_radius_m = road.radius_m->mean - bend_of(road) * lateral_m;
      const double along_m =
          random.uniform(-10.0, road.straight_m.mean + 2.0 * kPi / 3.0 * lane_radius_m);
      const auto point = point_of(road, along_m, lateral_m);
      const RoadPosition found = road_position(road, point.x_m, point.y_m);
      EXPECT_NEAR(found.along_m, along_m, kTolerance_m);
      EXPECT_NEAR(found.lateral_m, lateral_m, kTolerance_m);
    }
  }
}

TEST(Road, LeftAndRightBendsAreMirrorImages) {
  for (double along_m = 0.0; along_m < 70.0; along_m += 3.3) {
    const auto left = point_of(kRoads[1], along_m, 2.5);
    const auto right = point_of(kRoads[2], along_m, -2.5);
    EXPECT_DOUBLE_EQ(left.x_m, right.x_m);
    EXPECT_DOUBLE_EQ(left.y_m, -right.y_m);
    EXPECT_DOUBLE_EQ(left.heading_rad, -right.heading_rad);
  }
}

}  // namespace
}  // namespace vildar
