#include "estimate/pass_light.h"

#include <gtest/gtest.h>

#include "core/random.h"
#include "law_pass.h"

namespace vildar {
namespace {

using namespace law_pass;

PowerCase case_on(double bend, double straight_m, double cosine_exponent) {
  PowerCase known = case_of();
  known.law.cosine_exponent = cosine_exponent;
  known.exponent_std = 0.05;
  known.bend = bend;
  known.straight_m = {straight_m, 2.0};
  known.radius_m = {80.0, 3.0};
  return known;
}

// Central differences; the whole way on a straight, on an arc, and from one to the other.
TEST(PassLight, SlopesAreThoseOfItsResiduals) {
  constexpr double kStep = 1e-6, kRelative = 1e-5, kRipple_nat = 0.3;
  Random random(20261126);
  PowerSeries series = light_of(1, 0.0);
  series.background_std_w = 0.3 * series.power_w.front();
  for (const double bend : {0.0, 1.0, -1.0})
    for (const double straight_m : {0.0, 30.0})
      for (const double cosine_exponent : {0.0, 2.5})
        for (const bool fitted : {false, true}) {
          PowerCase known = case_on(bend, straight_m, cosine_exponent);
          if (fitted) known.log_gain_per_exponent = 3.0;
          const PassLight light(series, known, motion_of());
          Eigen::VectorXd z(kPassUnknowns);
          for (int i = 0; i < kPassUnknowns; ++i)
            z[i] = (i <= kLogAlong ? 0.02 : 0.5) * random.normal();
          const auto at = light.residuals(z, kRipple_nat, true);
          ASSERT_TRUE(at);
          for (int i = 0; i < kPassUnknowns; ++i) {
            Eigen::VectorXd up = z, down = z;
            up[i] += kStep;
            down[i] -= kStep;
            const auto above = light.residuals(up, kRipple_nat, false);
            const auto below = light.residuals(down, kRipple_nat, false);
            ASSERT_TRUE(above && below);
            const Eigen::VectorXd differences = (above->values - below->values) / (2.0 * kStep);
            const Eigen::VectorXd slopes = at->slopes.row(i).transpose();
            EXPECT_LE((slopes - differences).norm(), kRelative * (1.0 + differences.norm()))
                << "unknown " << i << ", bend " << bend << ", straight " << straight_m
                << ", cosine " << cosine_exponent << ", fitted " << fitted;
          }
        }
}

TEST(PassLight, UnknownsOfNoughtAreTheMotionTold) {
  const PowerCase known = case_of();
  PassMotion motion = motion_of();
  motion.acceleration_mps2 = -1.2;
  const PassLight light(light_of(1, 0.0), known, motion);
  const PassMotion found = light.motion_of(PassLight::nearest_to(motion));
  EXPECT_EQ(found.speed_mps, motion.speed_mps);
  EXPECT_EQ(found.along_m, motion.along_m);
  EXPECT_NEAR(found.acceleration_mps2, motion.acceleration_mps2, 1e-12);
}

}  // namespace
}  // namespace vildar
