#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "estimate/simulated_pass.h"
#include "estimate/two_traces.h"
#include "estimate/vehicle.h"
#include "pipelines/run_passes.h"
#include "pipelines/vehicle_power.h"

namespace vildar {
namespace {

// Three vehicles four seconds apart, each in view from 130 to 10 m: two at a time. Two photodiodes
// 2 m apart whose clock is late by so much receive the law's light of all.
class OwnPass : public ::testing::Test {
 protected:
  OwnPass() {
    for (int k = 0; k < 2; ++k) {
      PhotodiodeSite& diode = site_.photodiodes.emplace_back();
      diode.id = "pd" + std::to_string(k);
      diode.position_m = {Uncertain{2.0 * k}, Uncertain{0.0}, Uncertain{4.0}};
      diode.gain_ratio = {1.0, 0.002};
      diode.time_offset_s.std = 0.005;
    }
    for (int i = 0; i < 3; ++i) {
      const simulated::Vehicle vehicle{
          kSpeeds_mps[static_cast<std::size_t>(i)], 0.0, 130.0 + 80.0 * i, -4.0, 0.65, 1.2};
      vehicles_.push_back(vehicle);
      const auto at_s = [&](double ahead_m) {
        return (vehicle.along_m - ahead_m) / vehicle.speed_mps;
      };
      tracks_.push_back(
          track_of(vehicle, site_, {.from_s = at_s(130.0), .to_s = at_s(10.0)}, random_));
      tracks_.back().id = i + 1;
      lit_.push_back(lit_vehicle(tracks_.back(), site_));
    }
  }

  std::vector<PowerTrace> traces_of(double late_s) {
    constexpr double kNoise_w = 2e-5, kEnd_s = 18.0;
    return simulated::two_traces(kEnd_s, kNoise_w, random_, [&](int k, double t_s) {
      double light_w = 0.0;
      for (const simulated::Vehicle& vehicle : vehicles_) {
        const double ahead_m = vehicle.along_at_m(t_s - late_s) - 2.0 * k;
        if (ahead_m > 0.0) light_w += 1.0 / (ahead_m * ahead_m + 16.0 + 3.35 * 3.35);
      }
      return light_w;
    });
  }

  std::optional<PowerPass> pass_of(std::size_t own, const std::vector<PowerTrace>& traces) const {
    return own_pass(lit_, own, site_, traces, passes_of(traces));
  }

  static constexpr std::array<double, 3> kSpeeds_mps{20.0, 19.0, 20.5};
  Random random_{7};
  Site site_ = simulated::mast_site(4.0);
  std::vector<simulated::Vehicle> vehicles_;
  std::vector<VehicleTrack> tracks_;
  std::vector<LitVehicle> lit_;
};

TEST_F(OwnPass, EndsWhereTheVehiclePasses) {
  const auto traces = traces_of(0.0);
  for (std::size_t i = 0; i < lit_.size(); ++i) {
    const auto pass = pass_of(i, traces);
    ASSERT_TRUE(pass) << i;
    EXPECT_NEAR(pass->to_s, vehicles_[i].along_m / vehicles_[i].speed_mps, 0.15) << i;
  }
}

TEST_F(OwnPass, TellsTheDelayThoughOthersAreInView) {
  const auto traces = traces_of(0.0);
  for (std::size_t i = 0; i < lit_.size(); ++i) {
    const OfferedPower offered = offer_power(lit_, i, site_, traces);
    const auto pass = pass_of(i, traces);
    ASSERT_TRUE(pass) << i;
    const auto result =
        estimate_vehicle(tracks_[i], site_, offered.power, {{*pass, traces}}).result;
    const auto row =
        std::ranges::find(result.methods, Method::delay_photodiodes, &MethodResult::method);
    ASSERT_NE(row, result.methods.end());
    const auto* speed = std::get_if<SpeedEstimate>(&row->speed);
    ASSERT_TRUE(speed) << i << name_of(std::get<Miss>(row->speed));
    EXPECT_LT(speed->std_mps, 0.03 * kSpeeds_mps[i]) << i;
    EXPECT_LT(std::abs(speed->speed_mps - kSpeeds_mps[i]), 4.0 * speed->std_mps) << i;
    EXPECT_EQ(result.method, Method::fused) << i;
    EXPECT_LT(std::abs(result.speed.speed_mps - kSpeeds_mps[i]), 4.0 * result.speed.std_mps) << i;
  }
}

TEST_F(OwnPass, OfAWrongClockNone) {
  for (const double late_s : {-4.0, -1.0, 1.0, 1.9, 4.0}) {  // 4 s: the pass of a neighbour
    const auto traces = traces_of(late_s);
    for (std::size_t i = 0; i < lit_.size(); ++i) EXPECT_FALSE(pass_of(i, traces)) << late_s;
  }
}

TEST_F(OwnPass, NotOfAVehicleAloneNorBesideOneWhoseWayIsUnknown) {
  const auto traces = traces_of(0.0);
  lit_[1].way.reset();
  for (std::size_t i = 0; i < lit_.size(); ++i) EXPECT_FALSE(pass_of(i, traces)) << i;
  lit_.resize(1);
  EXPECT_FALSE(pass_of(0, traces));
}

}  // namespace
}  // namespace vildar
