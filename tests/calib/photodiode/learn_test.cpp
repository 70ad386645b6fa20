#include "calib/photodiode/learn.h"

#include <cmath>

#include <gtest/gtest.h>

#include "estimate/simulated_beam.h"
#include "far.h"
#include "simulated_photodiodes.h"

namespace vildar {
namespace {

GainLearning learned(const simulated::LitPasses& scene) {
  const auto outcome = learn_gains(scene.passes, scene.site);
  if (const Miss* miss = std::get_if<Miss>(&outcome))
    throw std::runtime_error(std::string(name_of(*miss)));
  return std::get<GainLearning>(outcome);
}

TEST(LearnGains, FindsTheGainRatio) {
  const simulated::LitPasses scene = simulated::lit_passes(12, 0.01, 1.08, 7);
  const GainLearning learning = learned(scene);
  ASSERT_EQ(learning.gains.size(), 1U);
  EXPECT_EQ(learning.gains[0].key, "photodiodes[1].gain_ratio");
  const Uncertain& ratio = learning.site.photodiodes[1].gain_ratio;
  EXPECT_LT(std::abs(ratio.mean - 1.08), kFar * ratio.std);
  EXPECT_LT(ratio.std, 0.02);  // of 0.1 before
  EXPECT_EQ(learning.site.photodiodes[0].gain_ratio, scene.site.photodiodes[0].gain_ratio);
  EXPECT_EQ(learning.site.photodiodes[1].time_offset_s, scene.site.photodiodes[1].time_offset_s);
  EXPECT_GE(learning.passes, 10);
  EXPECT_LE(learning.speed_std_after, 1.01 * learning.speed_std_before);
}

TEST(LearnGains, APassUnlikeTheOthersIsLeftOut) {
  simulated::LitPasses scene = simulated::lit_passes(12, 0.01, 1.0, 8);
  for (float& power_w : scene.traces[4][1].power_w) power_w *= 0.8F;  // an insect on the lens
  const GainLearning learning = learned(scene);
  EXPECT_EQ(learning.left_out.count("unlike_the_others"), 1U);
  const Uncertain& ratio = learning.site.photodiodes[1].gain_ratio;
  EXPECT_LT(std::abs(ratio.mean - 1.0), kFar * ratio.std);
  EXPECT_LT(ratio.std, 0.02);
}

// What parts the passes by more than the file says of a gain is no gain, and no surer for it.
TEST(LearnGains, PassesThatDifferByMoreThanIsStatedLeaveItUnsure) {
  simulated::LitPasses scene = simulated::lit_passes(8, 0.01, 1.0, 8);
  for (PhotodiodeSite& photodiode : scene.site.photodiodes) photodiode.gain_ratio.std = 0.02;
  for (std::size_t i = 0; i < scene.traces.size(); ++i)
    for (float& power_w : scene.traces[i][1].power_w) power_w *= i % 2 == 0 ? 1.06F : 0.94F;
  const LearnedGain gain = learned(scene).gains.at(0);
  ASSERT_GE(gain.passes, kFewestGainPasses);
  EXPECT_GT(gain.spread, 0.04);
  EXPECT_TRUE(gain.differs);
  EXPECT_GE(gain.after.std, gain.spread);
}

TEST(LearnGains, SaysWhatIsMissing) {
  simulated::LitPasses scene = simulated::lit_passes(4, 0.0, 1.0, 9);
  const GainLearning few = learned(scene);
  EXPECT_LT(few.passes, kFewestGainPasses);
  EXPECT_EQ(few.site.photodiodes[1].gain_ratio, scene.site.photodiodes[1].gain_ratio);
  for (PhotodiodeSite& photodiode : scene.site.photodiodes) photodiode.gain_ratio.std = 0.0;
  EXPECT_EQ(std::get<Miss>(learn_gains(scene.passes, scene.site)), Miss::unobservable);
}

}  // namespace
}  // namespace vildar
