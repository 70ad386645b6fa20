#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "estimate/simulated_pass.h"
#include "estimate/simulated_power.h"
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

// One comes at 20 m/s in the near lane while another drives away at 12 m/s in the far one, whose
// tail lamps shine a tenth as bright.
class TailLamps : public ::testing::Test {
 protected:
  TailLamps() {
    site_.road.lanes.push_back({"far", {-7.5, 0.3}, 3.5, Direction::receding});
    site_.photodiodes.resize(1);
    site_.photodiodes[0].position_m = {Uncertain{0.0}, Uncertain{0.0}, Uncertain{4.0}};
    site_.channel = ChannelSite{};
    site_.channel->path_loss_exponent = Uncertain{2.0, 0.0};
    VehicleTrack away = track_of(away_, site_, {.from_s = 0.3, .to_s = 3.5}, random_);
    away.direction = Direction::receding;
    away.kind = LampKind::taillamp;
    lit_ = {lit_vehicle(track_of(comes_, site_, {.from_s = 0.0, .to_s = 2.4}, random_), site_),
            lit_vehicle(away, site_)};
    simulated::Diode tails = kDiode;
    tails.gain_w *= 0.1;
    tails.ambient_w = tails.noise_w = 0.0;
    alone_ = simulated::trace_of(comes_, site_, kDiode, random_);
    PowerTrace both = alone_;
    const PowerTrace away_light = simulated::trace_of(away_, site_, tails, random_);
    for (std::size_t i = 0; i < both.power_w.size(); ++i) both.power_w[i] += away_light.power_w[i];
    traces_ = {both};
  }

  static constexpr simulated::Diode kDiode{
      .from_s = -2.0, .to_s = 6.0, .gain_w = 1.0, .ambient_w = 1e-3, .noise_w = 1e-6};
  const simulated::Vehicle comes_{20.0, 0.0, 60.0, -4.0, 0.65, 1.2};
  const simulated::Vehicle away_{-12.0, 0.0, 12.0, -7.5, 0.85, 1.3};
  Random random_{11};
  Site site_ = simulated::mast_site(4.0);
  std::vector<LitVehicle> lit_;
  PowerTrace alone_;
  std::vector<PowerTrace> traces_;
};

TEST_F(TailLamps, OfAVehicleThatDrivesAwayAreTakenOutOfTheLight) {
  const OfferedPower offered = offer_power(lit_, 0, site_, traces_);
  EXPECT_FALSE(offered.unexplained);
  ASSERT_FALSE(offered.power.front().shared);
  const PowerTrace& own = *offered.power.front().trace;
  ASSERT_GT(own.time_s.size(), 500U);
  EXPECT_LT(own.ambient_sigma_w, 20.0 * kDiode.noise_w);  // 3 % of the tail lamps
  for (std::size_t i = 0; i < own.time_s.size(); ++i) {
    const auto k = static_cast<std::size_t>(std::lround((own.time_s[i] + 2.0) * 1000.0));
    EXPECT_NEAR(own.power_w[i], alone_.power_w[k], 4.0 * own.ambient_sigma_w + 8.0 * kDiode.noise_w)
        << own.time_s[i];
  }
}

TEST_F(TailLamps, ThatTheCameraDoesNotSeeAreUnexplained) {
  lit_.pop_back();
  EXPECT_TRUE(offer_power(lit_, 0, site_, traces_).unexplained);
}

TEST_F(TailLamps, TooFaintToTellLeaveTheTraceAsItIs) {
  for (std::size_t i = 0; i < alone_.power_w.size(); ++i)
    traces_[0].power_w[i] = alone_.power_w[i] + 1e-3F * (traces_[0].power_w[i] - alone_.power_w[i]);
  const OfferedPower offered = offer_power(lit_, 0, site_, traces_);
  EXPECT_FALSE(offered.unexplained);
  EXPECT_EQ(offered.power.front().own_light, nullptr);
  EXPECT_EQ(offered.power.front().trace->power_w, traces_[0].power_w);
}

// Light that runs backwards is neither's.
TEST_F(TailLamps, DoNotExplainAnyLight) {
  std::ranges::reverse(traces_[0].power_w);
  const OfferedPower offered = offer_power(lit_, 0, site_, traces_);
  EXPECT_TRUE(offered.unexplained);
  ASSERT_TRUE(offered.power.front().own_light);
  EXPECT_TRUE(offered.power.front().own_light->time_s.empty());
}

}  // namespace
}  // namespace vildar
