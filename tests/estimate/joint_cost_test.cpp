#include "estimate/joint_cost.h"

#include <gtest/gtest.h>

#include "core/random.h"

namespace vildar {
namespace {

struct Case {
  GeometryProblem problem;
  LightSetting light;
  Receiver receiver;
  LitBlock block;
  std::array<double, kPathParameters> path{};
  std::array<double, kLightParameters> of_light{};
  std::array<double, kReceiverParameters> own{};

  BlockResidual residual() const { return {light, receiver, block}; }
  double error() const {
    const std::array<const double*, 3> all{path.data(), of_light.data(), own.data()};
    double value = 0.0;
    EXPECT_TRUE(residual().Evaluate(all.data(), &value, nullptr));
    return value;
  }
};

Case drawn(double bend, Random& random) {
  Case made;
  made.problem.setting.camera_m = {0.0, 0.0, 5.0};
  made.problem.setting.bend = bend;
  made.problem.setting.straight_m = 10.0;
  made.problem.setting.steps = {{-0.4, random.normal(0.0, 0.05)}, {0.3, random.normal(0.0, 0.05)}};
  made.receiver.position_m = {1.0, 0.5, 4.5};
  made.light.cosine_exponent = 1.0;
  made.light.log_scale = std::log(30.0);
  made.block = {.time_s = random.uniform(-0.8, 0.8), .power = 0.4, .bulge = 1.01, .sigma = 0.02};
  made.path[kLogScale] = std::log(random.uniform(25.0, 45.0));
  made.path[kClosingRate] = random.uniform(0.3, 0.6);
  made.path[kAcceleration] = random.normal(0.0, 0.05);
  made.path[kLateral] = random.normal(-0.1, 0.05);
  made.path[kDrop] = random.normal(-0.1, 0.02);
  made.path[kLogRadius] = std::log(2.0);
  made.problem.setting.straight_unsure = bend > 0.0;
  made.path[kStraight] = 10.0 / std::exp(made.path[kLogScale]);
  made.path[kLogSeparation] = std::log(0.04);
  for (double& one : made.of_light) one = random.normal(0.0, 0.3);
  made.of_light[kExponent] = random.uniform(1.5, 2.5);
  made.of_light[kBeamWidth] = random.normal(0.0, 10.0);
  for (double& one : made.own) one = random.normal(0.0, 0.1);
  return made;
}

TEST(BlockResidual, SlopesAreThoseOfDifferences) {
  constexpr double kRounding = 1e-12;
  constexpr double kStep = 1e-6, kRelative = 1e-6;  // third derivatives are of the order of one
  Random random(5);
  for (int trial = 0; trial < 60; ++trial) {
    Case made = drawn(trial % 3 - 1.0, random);
    made.problem.pairs = trial % 2 == 0;
    made.light.problem = &made.problem;
    std::array<double, kPathParameters> by_path{};
    std::array<double, kLightParameters> by_light{};
    std::array<double, kReceiverParameters> by_own{};
    const std::array<const double*, 3> all{made.path.data(), made.of_light.data(), made.own.data()};
    std::array<double*, 3> slopes{by_path.data(), by_light.data(), by_own.data()};
    double value = 0.0;
    ASSERT_TRUE(made.residual().Evaluate(all.data(), &value, slopes.data()));
    EXPECT_NEAR(value, made.error(), kRounding * (1.0 + std::abs(value)));
    const auto compare = [&](auto& unknowns, const auto& stated, const char* what) {
      for (std::size_t i = 0; i < unknowns.size(); ++i) {
        const double at = unknowns[i];
        unknowns[i] = at + kStep;
        const double above = made.error();
        unknowns[i] = at - kStep;
        const double below = made.error();
        unknowns[i] = at;
        const double slope = (above - below) / (2.0 * kStep);
        EXPECT_NEAR(stated[i], slope, kRelative * (10.0 + std::abs(slope) + std::abs(value)))
            << what << " " << i;
      }
    };
    compare(made.path, by_path, "path");
    compare(made.of_light, by_light, "light");
    compare(made.own, by_own, "own");
  }
}

// Written out for lamps each in its own place: free space, cosine of incidence, even beam.
TEST(LogPower, APairShinesInHalvesFromItsTwoPlaces) {
  Random random(7);
  Case made = drawn(0.0, random);
  made.light.problem = &made.problem;
  made.problem.pairs = true;
  made.problem.setting.steps.clear();
  made.of_light.fill(0.0);
  made.of_light[kLogGain] = 0.4;
  made.of_light[kExponent] = 2.0;
  made.light.log_scale = made.path[kLogScale];
  constexpr double kTau_s = 0.4, kMoved_m = 0.3;
  double value = 0.0;
  ASSERT_TRUE(log_power(made.path.data(), made.of_light.data(), made.light,
                        made.receiver.position_m, kMoved_m, kTau_s, value));
  const double scale_m = std::exp(made.path[kLogScale]);
  const double along =
      1.0 - kTau_s * (made.path[kClosingRate] + 0.5 * kTau_s * made.path[kAcceleration]);
  const Eigen::Vector3d middle_m(scale_m * along, scale_m * made.path[kLateral],
                                 5.0 - scale_m * made.path[kDrop]);
  double sum = 0.0;
  for (const double side : {-0.02, 0.02}) {
    const Eigen::Vector3d apart_m =
        middle_m + Eigen::Vector3d(-kMoved_m, side * scale_m, 0.0) - made.receiver.position_m;
    sum += 0.5 * std::exp(0.4) * scale_m * scale_m * apart_m.x() / std::pow(apart_m.norm(), 3);
  }
  EXPECT_NEAR(value, std::log(sum), 1e-12);
}

TEST(LogPower, TellsNoLengthByWhereThePhotodiodeStands) {
  Random random(8);
  Case made = drawn(0.0, random);
  made.light.problem = &made.problem;
  made.problem.pairs = true;
  const auto value_at = [&](double log_scale) {
    made.path[kLogScale] = log_scale;
    double value = 0.0;
    EXPECT_TRUE(log_power(made.path.data(), made.of_light.data(), made.light,
                          Eigen::Vector3d(3.0, -9.0, 4.0), 0.0, 0.3, value));
    return value;
  };
  EXPECT_NEAR(value_at(std::log(36.0)), value_at(std::log(30.0)), 1e-12);
}

TEST(BlockResidual, HasNoneForAVehicleThatIsPast) {
  Random random(6);
  Case made = drawn(0.0, random);
  made.light.problem = &made.problem;
  made.own[kAhead] = 100.0;
  const std::array<const double*, 3> all{made.path.data(), made.of_light.data(), made.own.data()};
  double value = 0.0;
  EXPECT_FALSE(made.residual().Evaluate(all.data(), &value, nullptr));
}

}  // namespace
}  // namespace vildar
