#include <gtest/gtest.h>

#include "pipelines/run_clip.h"

namespace vildar {
namespace {

// 20 s at 100 Hz; the value of a sample is its index.
PowerTrace ramp() {
  PowerTrace trace;
  for (int i = 0; i < 2000; ++i) {
    trace.time_s.push_back(0.01 * i);
    trace.power_w.push_back(static_cast<float>(i));
  }
  return trace;
}

TEST(AloneOnTrace, KeepsTheTimeBetweenNeighbours) {
  const std::vector<ClipInterval> others{{0.0, 7.0}, {9.0, 12.0}};
  const auto cut = alone_on_trace(ramp(), 0.0, {6.0, 10.0}, others);
  ASSERT_TRUE(cut);
  EXPECT_NEAR(cut->time_s.front(), 7.0, 0.011);
  EXPECT_NEAR(cut->time_s.back(), 9.0, 0.011);
  EXPECT_EQ(cut->power_w.front(), static_cast<float>(std::lround(cut->time_s.front() * 100.0)));
  EXPECT_EQ(cut->power_w.size(), cut->time_s.size());
}

TEST(AloneOnTrace, IsAsSureAsTheWholeTrace) {
  PowerTrace trace = ramp();
  static_cast<PowerTraceFacts&>(trace) = {"near",
                                          1,
                                          0.01,
                                          1e-3,
                                          2e-3,
                                          0.5,
                                          4e-3,
                                          50.0,
                                          0.1,
                                          0.2,
                                          5e-8,
                                          {{6.0, 7.0, 200.0, 0.3, 0.02}},
                                          {{"clipped", 3}},
                                          {{8.0, 8.5}},
                                          {}};
  const auto cut = alone_on_trace(trace, 0.0, {6.0, 10.0}, {});
  ASSERT_TRUE(cut);
  EXPECT_EQ(static_cast<const PowerTraceFacts&>(*cut), trace);
}

TEST(AloneOnTrace, TakesTheLongerOfTwoFreeStretches) {
  const std::vector<ClipInterval> others{{6.5, 7.0}};
  const auto cut = alone_on_trace(ramp(), 0.0, {6.0, 10.0}, others);
  ASSERT_TRUE(cut);
  EXPECT_GE(cut->time_s.front(), 7.0 - 1e-9);
  EXPECT_GT(cut->time_s.back(), 10.0);
}

TEST(AloneOnTrace, NothingWhereAnotherVehicleCoversTheView) {
  EXPECT_FALSE(
      alone_on_trace(ramp(), 0.0, {6.0, 10.0}, std::vector<ClipInterval>{{5.0, 8.0}, {7.5, 9.8}}));
}

TEST(AloneOnTrace, ClipTimeIsPhotodiodeTimePlusOffset) {
  const auto cut = alone_on_trace(ramp(), 2.0, {8.0, 10.0}, std::vector<ClipInterval>{{0.0, 8.5}});
  ASSERT_TRUE(cut);
  EXPECT_NEAR(cut->time_s.front(), 6.5, 0.011);
}

// One vehicle in view from 6 to 8 s; another comes into view half a second later.
TEST(OfferedPower, EndsWhereAFollowerComesIntoView) {
  Site site;
  site.photodiodes.resize(1);
  const std::vector<PowerTrace> traces{ramp()};
  std::vector<LitVehicle> lit{{1, {6.0, 8.0}, 8.4, {}}, {2, {8.5, 11.0}, 11.4, {}}};
  EXPECT_NEAR(offer_power(lit, 0, site, traces).power.front().trace->time_s.back(), 8.5, 0.011);
  // Which is known only when the other has been followed to its end.
  EXPECT_FALSE(company_known(lit[0].in_view, lit[1].in_view.from_s));
  // Light of one yet to come is there before it is in view.
  EXPECT_FALSE(company_known(lit[0].in_view, 12.5));
  EXPECT_TRUE(company_known(lit[0].in_view, 14.5));
}

TEST(OfferedPower, NeedsNoVehicleThatWasPastBefore) {
  const LitVehicle past{1, {6.0, 8.0}, 8.4, {}};
  EXPECT_FALSE(dark_since(past, 8.6));  // traces are read from half a second before a view
  EXPECT_TRUE(dark_since(past, 9.0));
}

}  // namespace
}  // namespace vildar
