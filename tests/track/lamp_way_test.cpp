#include "track/lamp_way.h"

#include <gtest/gtest.h>

#include "one_car.h"

namespace vildar {
namespace {

constexpr double kFrame_s = 0.04;

Eigen::Vector2d spot_at(const scene::OneCar& road, double frame, double y_m) {
  return *road.view.spot_from_pixel(*road.camera.project({70.0 - 0.5 * frame, y_m, 0.68}));
}

std::vector<PairPlace> pairs_in(const scene::OneCar& road, int first, int last) {
  std::vector<PairPlace> pairs;
  for (int frame = first; frame <= last; ++frame)
    pairs.push_back({kFrame_s * frame, spot_at(road, frame, -3.4), spot_at(road, frame, -4.6)});
  return pairs;
}

TEST(LampWay, GoesOnBeforeBetweenAndAfterThePairs) {
  const scene::OneCar road;
  std::vector<PairPlace> pairs = pairs_in(road, 20, 40);
  pairs.erase(pairs.begin() + 8, pairs.begin() + 12);
  const LampWay way(pairs, road.view);
  constexpr double kNear_px = 1.0;  // the pairs' depth is between separation and elevation
  for (const int frame : {5, 30, 55}) {
    const auto place = way.at(kFrame_s * frame);
    ASSERT_TRUE(place) << frame;
    EXPECT_LT((place->left_px - spot_at(road, frame, -3.4)).norm(), kNear_px) << frame;
    EXPECT_LT((place->right_px - spot_at(road, frame, -4.6)).norm(), kNear_px) << frame;
    EXPECT_EQ(place->along_px < kNear_px, frame == 30);
  }
  EXPECT_FALSE(way.at(kFrame_s * 150));  // behind the camera
}

TEST(LampWay, NotFromFewPairsOrASensorThatMoves) {
  const scene::OneCar road;
  EXPECT_FALSE(LampWay(pairs_in(road, 20, 26), road.view).at(kFrame_s * 30));
  Site dashcam = road.site;
  dashcam.ego.emplace();
  const RoadView moving(dashcam);
  EXPECT_FALSE(LampWay(pairs_in(road, 20, 40), moving).at(kFrame_s * 30));
}

}  // namespace
}  // namespace vildar
