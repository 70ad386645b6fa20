#include "track/lone_light.h"

#include <cmath>

#include <gtest/gtest.h>

#include "one_car.h"

namespace vildar {
namespace {

TEST(LoneLight, OddsFallWithEveryCueOfAGlint) {
  const LoneLight lamp{0.0, 0.0, 1.0, true, -0.4};
  double last = lone_lamp_log_odds(lamp);
  EXPECT_GT(last, std::log(20.0));
  for (const double share : {0.2, 0.4, 0.6, 0.8, 1.0}) {
    const LoneLight light{share, share, 1.0 - share, true, -0.4 - 2.0 * share};
    EXPECT_LT(lone_lamp_log_odds(light), last) << share;
    last = lone_lamp_log_odds(light);
  }
  EXPECT_LT(last, -std::log(20.0));
}

TEST(LoneLight, NotToClipSpeaksAgainstALampOnlyWhereLampsClip) {
  for (const bool lamps_clip : {false, true}) {
    const double dim = lone_lamp_log_odds({0.0, 0.0, 0.0, lamps_clip, {}});
    const double clipped = lone_lamp_log_odds({0.0, 0.0, 1.0, lamps_clip, {}});
    EXPECT_GT(clipped, dim);
    EXPECT_EQ(dim > 0.0, !lamps_clip);
  }
}

TEST(LoneLight, AHighBeamIsNoLessALamp) {
  EXPECT_DOUBLE_EQ(lone_lamp_log_odds({0.0, 0.0, 1.0, true, -0.4}),
                   lone_lamp_log_odds({0.0, 0.0, 1.0, true, 2.0}));
}

// A twentieth of a strong lamp's light; nothing else speaks against a lamp.
TEST(LoneLight, ABicyclesLampIsOne) {
  EXPECT_GT(lone_lamp_log_odds({0.0, 0.0, 1.0, true, -3.0}), std::log(3.0));
  EXPECT_LT(lone_lamp_log_odds({0.3, 0.0, 1.0, true, -3.0}), std::log(3.0));
}

TEST(LoneLight, SeveralLampsInOneAreNoLamp) {
  EXPECT_LT(lone_lamp_log_odds({0.0, 0.0, 1.0, true, 4.0}), -std::log(20.0));
}

TEST(LoneLight, OddsFallWithLooksAtWhichItIsNoLamp) {
  double last = lone_lamp_log_odds({0.0, 0.0, 1.0, true, {}});
  for (const double share : {0.2, 0.4, 0.6, 0.8}) {
    const double misshapen = lone_lamp_log_odds({0.0, 0.0, 1.0, true, {}, share});
    const double both = lone_lamp_log_odds({0.0, 0.0, 1.0, true, {}, share, share});
    EXPECT_LT(misshapen, last);
    EXPECT_LT(both, misshapen);
    last = misshapen;
  }
}

TEST(LoneLight, ItsImageOnTheRoadSpeaksForALampAndFramesUnseenAgainstOne) {
  LoneLight faint{0.2, 0.1, 1.0, true, -2.5};
  EXPECT_LT(lone_lamp_log_odds(faint), std::log(3.0));
  faint.imaged_share = 0.9;
  EXPECT_GT(lone_lamp_log_odds(faint), std::log(3.0));
  LoneLight seldom{0.0, 0.0, 1.0, true, -1.5};
  EXPECT_GT(lone_lamp_log_odds(seldom), std::log(20.0));
  seldom.unseen_share = 0.7;
  EXPECT_LT(lone_lamp_log_odds(seldom), std::log(20.0));
}

TEST(LoneLight, OddsFallWithTimeAsOneOfAPairOrBesideItsCourse) {
  for (double LoneLight::*cue : {&LoneLight::paired_share, &LoneLight::off_course_share}) {
    LoneLight light{0.0, 0.0, 1.0, true, -1.0};
    double last = lone_lamp_log_odds(light);
    for (const double share : {0.2, 0.4, 0.6, 0.8}) {
      light.*cue = share;
      EXPECT_LT(lone_lamp_log_odds(light), last) << share;
      last = lone_lamp_log_odds(light);
    }
  }
}

TEST(LoneLight, ALampGrowsSteadilyAndIsNoMetreWide) {
  const Site site = scene::site_of(5.0, -4.0, 1400.0, 1920, 1080);
  const RoadView view(site);
  const auto at_px = view.spot_from_pixel(*Camera(*site.camera).project({60.0, -4.0, 0.68}));
  const auto share_of = [&](const std::vector<int>& widths_px) {
    std::vector<LampRecord> records;
    for (const int width_px : widths_px) {
      LampRecord& record = records.emplace_back();
      record.at_px = *at_px;  // a metre is 23 px there
      record.sighting.box = {0, 0, width_px - 1, 7};
    }
    return misshapen_share(records, view);
  };
  EXPECT_EQ(share_of({4, 4, 5, 4, 5, 5, 6, 6, 7, 7, 8, 9, 9, 10}), 0.0);
  EXPECT_EQ(share_of({30, 32, 34, 33, 35, 34}), 1.0);
  EXPECT_GT(share_of({1, 6, 5, 12, 1, 7, 12, 2, 6, 13}), 0.4);
}

TEST(LoneLight, GlareIsRoundAndClipsAndHardlyGrows) {
  constexpr int kLooks = 20;
  const Site site = scene::site_of(5.0, -4.0, 1400.0, 1920, 1080);
  const RoadView view(site);
  const Camera camera(*site.camera);
  // From 120 to 60 m; a metre is 12 to 23 px.
  const auto share_of = [&](double grows, double slender, double clipped) {
    std::vector<LampRecord> records;
    for (int look = 0; look < kLooks; ++look) {
      const double along_m = 120.0 - 60.0 * look / (kLooks - 1);
      LampRecord& record = records.emplace_back();
      record.at_px = *view.spot_from_pixel(*camera.project({along_m, -4.0, 0.68}));
      const double width_px = 28.0 * std::pow(120.0 / along_m, grows);
      record.sighting.box = {0, 0, static_cast<int>(width_px) - 1,
                             static_cast<int>(slender * width_px) - 1};
      record.sighting.saturated_px = static_cast<int>(clipped * slender * width_px * width_px);
    }
    return misshapen_share(records, view);
  };
  EXPECT_EQ(share_of(0.1, 1.0, 0.5), 0.0);
  EXPECT_EQ(share_of(1.0, 1.0, 0.5), 1.0);
  EXPECT_EQ(share_of(0.1, 1.0, 0.1), 1.0);
  EXPECT_EQ(share_of(0.1, 0.6, 0.5), 1.0);
}

TEST(LoneLight, InAnotherLampsColumnNowAndThenIsByChanceAndForLongIsItsGlint) {
  LoneLight light{0.0, 0.0, 1.0, true, -1.0};
  const double alone = lone_lamp_log_odds(light);
  light.below_share = 0.15;
  EXPECT_DOUBLE_EQ(lone_lamp_log_odds(light), alone);
  light.below_share = 0.9;
  EXPECT_LT(lone_lamp_log_odds(light), alone - std::log(20.0));
}

}  // namespace
}  // namespace vildar
