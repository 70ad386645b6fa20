#include "track/lone_course.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/clock.h"
#include "core/quantity.h"
#include "core/random.h"
#include "one_car.h"

namespace vildar {
namespace {

constexpr double kOutlierSlack = 0.05;  // three looks of 61

TEST(LoneCourse, ALampKeepsOneThoughAFewLooksAreAtOtherLights) {
  const scene::OneCar road;
  EXPECT_EQ(off_course_share(road.lamp(0, 60, -4.0).records, road.view), 0.0);
  const Lamp mostly = road.lamp(0, 60, [](std::int64_t frame) { return frame % 4 ? -4.0 : -7.0; });
  EXPECT_NEAR(off_course_share(mostly.records, road.view), 0.25, kOutlierSlack);
}

// A lamp's, then the road it lights, then another's.
TEST(LoneCourse, ALightThatGoesFromOneToTheNextHasNone) {
  const scene::OneCar road;
  const auto y_m = [](std::int64_t frame) { return frame < 20 ? -4.0 : frame < 40 ? -7.0 : -5.0; };
  const Lamp wanders = road.lamp(0, 60, y_m);
  EXPECT_GT(off_course_share(wanders.records, road.view), 0.5);
  Site moving = road.site;
  moving.ego = EgoSite{};
  EXPECT_EQ(off_course_share(wanders.records, RoadView(moving)), 0.0);
}

TEST(LoneCourse, ALampBeforeACameraThatShakesKeepsOne) {
  const scene::OneCar road;
  Random random(3);
  for (const double hz : {1.0, 2.5, 4.0}) {
    Lamp lamp = road.lamp(0, 60, -4.0);
    for (LampRecord& record : lamp.records) {
      const double angle = 2.0 * kPi * hz * seconds_of(record.time);
      record.at_px += 10.0 * Eigen::Vector2d(0.7 * std::cos(angle), std::sin(angle)) +
                      Eigen::Vector2d(random.normal(), random.normal());
    }
    EXPECT_LT(off_course_share(lamp.records, road.view), 0.1) << hz;
  }
}

}  // namespace
}  // namespace vildar
