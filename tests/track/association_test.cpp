#include "track/association.h"

#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "one_car.h"

namespace vildar {
namespace {

using Road = scene::OneCar;

class CommonShiftOf : public ::testing::Test {
 protected:
  static constexpr std::int64_t kLast = 20;
  static constexpr double kReach_px = 60.0;

  CommonShiftOf() {
    for (const double ahead_m : {0.0, 25.0})
      for (const double y_m : {-3.4, -4.6, -6.9, -8.1})
        lamps_.push_back(std::make_unique<Lamp>(road_.lamp(0, kLast, y_m, ahead_m)));
    for (const auto& lamp : lamps_) lamp->predict(0.04, road_.view);
  }
  void see(const Eigen::Vector2d& off_px) {
    for (const auto& lamp : lamps_) spots_.push_back({&blob_, lamp->at_px() + off_px});
  }
  Eigen::Vector2d shift_px() const { return common_shift(lamps_, spots_, kReach_px).by_px; }

  Road road_;
  Blob blob_;
  Lamps lamps_;
  std::vector<Spot> spots_;
};

TEST_F(CommonShiftOf, IsWhereAllLampsWent) {
  for (const auto& gone_px : {Eigen::Vector2d(9.0, -14.0), Eigen::Vector2d(1.2, 1.3)}) {
    spots_.clear();
    see(gone_px);
    EXPECT_NEAR((shift_px() - gone_px).norm(), 0.0, 1e-9);
  }
}

// A wet road shows all lamps again, a little below each; and a glint that was seen before is not
// seen now, but another one is as far below it.
TEST_F(CommonShiftOf, IsNotFromLampsToTheirImages) {
  const Eigen::Vector2d below_px(0.0, 12.0), beside_px(15.0, 0.0);
  auto glint = std::make_unique<Lamp>(*lamps_.back());
  glint->shift(below_px + beside_px, 0.04);
  see({0.1, 0.1});
  see(below_px);
  spots_.push_back({&blob_, glint->at_px() + below_px});
  lamps_.push_back(std::move(glint));
  EXPECT_TRUE(shift_px().isZero()) << shift_px().transpose();
}

// Even where the camera shook by as much: then the lamps stand where nothing was.
TEST_F(CommonShiftOf, OfACameraThatShookOverAWetRoad) {
  see({0.0, 12.0});
  see({0.0, 24.0});
  EXPECT_NEAR((shift_px() - Eigen::Vector2d(0.0, 12.0)).norm(), 0.0, 1e-9);
}

// A lamp goes on as one whose colour is another's, but not where that is left to chance.
TEST(Associate, AFaintLampMayLoseItsColour) {
  const Road road;
  for (const double chance : {0.0, 0.1}) {
    Lamps lamps;
    lamps.push_back(std::make_unique<Lamp>(road.lamp(0, 20, -3.4)));
    ASSERT_EQ(lamps.front()->kind(), LampKind::headlamp);
    const bool faint = chance > 0.0;
    for (std::int64_t frame = 21; frame <= 60; ++frame) {
      Blob blob;
      blob.centre_px = *road.camera.project({70.0 - 0.5 * static_cast<double>(frame), -3.4, 0.68});
      blob.flux = 100.0;
      blob.kind = LampKind::taillamp;
      blob.cr = 0.06;
      blob.colour_chance = chance;
      const std::vector<Spot> spots{{&blob, *road.view.spot_from_pixel(blob.centre_px), 0.5,
                                     blob.centre_px, blob.centre_sigma_px}};
      lamps.front()->predict(0.04, road.view);
      const Association found = associate(lamps, spots, 16.0, road.view);
      ASSERT_EQ(found.spot_of_lamp[0].has_value(), faint) << frame;
      if (!faint) break;
      lamps.front()->update(spots.front(), frame, Road::time_at(frame));
      ASSERT_EQ(lamps.front()->kind(), LampKind::headlamp) << frame;
    }
  }
}

// Hidden for a while, it may come out as far beyond where it would be as behind where it was, but
// for that it has not driven back.
TEST(Associate, AHiddenLampDoesNotComeOutBehindItself) {
  const Road road;
  for (const bool back : {true, false}) {
    Lamps lamps;
    lamps.push_back(std::make_unique<Lamp>(road.lamp(0, 5, -3.4)));
    Lamp& lamp = *lamps.front();
    const Eigen::Vector2d last_px = lamp.at_px();
    for (int i = 0; i < 45; ++i) lamp.predict(0.04, road.view);
    const Eigen::Vector2d moved_px = lamp.at_px() - last_px;
    ASSERT_GT(moved_px.norm(), 15.0);
    Blob blob;
    blob.flux = std::exp(lamp.log_flux());
    blob.kind = LampKind::headlamp;
    const Eigen::Vector2d at_px = last_px + (back ? -0.5 : 2.5) * moved_px;
    const std::vector<Spot> spots{{&blob, at_px, 0.5, at_px, blob.centre_sigma_px}};
    EXPECT_TRUE(lamp.distance_within(spots[0], 1e3));
    EXPECT_EQ(associate(lamps, spots, 1e3, road.view).spot_of_lamp[0].has_value(), !back);
  }
}

}  // namespace
}  // namespace vildar
