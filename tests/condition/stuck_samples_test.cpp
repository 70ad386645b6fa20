#include "condition/stuck_samples.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "condition/condition.h"
#include "core/random.h"

namespace vildar {
namespace {

constexpr double kNoise = 1.0;

struct Samples {
  std::vector<double> time_s;
  std::vector<float> values;
};

/// Twenty seconds at 1 kHz: a dark level that sinks by 3, noise, and two vehicles that come and
/// vanish at 8 and 16 s; rounded to whole steps where there are such.
Samples samples_with(double noise, double step) {
  Random random(11);
  Samples samples;
  for (int k = 0; k < 20'000; ++k) {
    const double time_s = 1e-3 * k;
    double value = 53.4 - 0.15 * time_s + random.normal(0.0, 1.0) * noise;
    for (const double past_s : {8.0, 16.0})
      if (const double range_m = 15.0 * (past_s - time_s); range_m > 0.0 && range_m < 80.0)
        value += 1e5 / (range_m * range_m + 36.0);
    if (step > 0.0) value = step * std::round(value / step);
    samples.time_s.push_back(time_s);
    samples.values.push_back(static_cast<float>(value));
  }
  return samples;
}

/// From sample `first` on, `count` samples repeat the one before.
void hang(Samples& samples, std::size_t first, std::size_t count) {
  for (std::size_t i = first; i < first + count; ++i) samples.values[i] = samples.values[i - 1];
}

std::vector<Span> stuck(const Samples& samples) {
  return stuck_runs(samples.time_s, samples.values);
}

void expect_one(const std::vector<Span>& runs, std::size_t first, std::size_t last,
                const std::string& of) {
  ASSERT_EQ(runs.size(), 1U) << of;
  EXPECT_EQ(runs[0].first, first) << of;
  EXPECT_EQ(runs[0].last, last) << of;
}

TEST(StuckRuns, AHangIsFoundInTheDarkAndInLight) {
  for (const double step : {0.0, 1.0})
    for (const std::size_t first : {2'000, 7'500, 7'900, 12'000, 19'000}) {
      Samples samples = samples_with(kNoise, step);
      samples.values[first + 1'000] = 60.0F;  // not the held value by chance
      samples.values[first - 2] = samples.values[first - 1] + 1.0F;
      hang(samples, first, 1'000);
      // The held sample itself cannot be told from those that repeat it.
      expect_one(stuck(samples), first - 1, first + 1'000,
                 "at " + std::to_string(first) + ", step " + std::to_string(step));
    }
}

TEST(StuckRuns, AShortOneBendsNothingAndStays) {
  Samples samples = samples_with(kNoise, 0.0);
  hang(samples, 7'500, 40);
  EXPECT_TRUE(stuck(samples).empty());
  hang(samples, 7'500, 60);
  EXPECT_EQ(stuck(samples).size(), 1U);
}

TEST(StuckRuns, SeveralAreFoundWhereTheyAreNotTheRule) {
  Samples samples = samples_with(kNoise, 0.0);
  for (const std::size_t first : {1'000, 4'000, 7'600, 10'000, 13'000}) hang(samples, first, 900);
  EXPECT_EQ(stuck(samples).size(), 5U);
}

TEST(StuckRuns, NoConverterIsTooCoarse) {
  for (const double noise : {0.0, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 2.0, 10.0})
    EXPECT_TRUE(stuck(samples_with(noise, 1.0)).empty()) << noise << " steps";
  EXPECT_TRUE(stuck(samples_with(1.0, 30.0)).empty());
}

TEST(StuckRuns, ALightWithoutNoiseMayStand) {
  Samples pulses = samples_with(0.0, 0.0);
  for (std::size_t i = 0; i < pulses.values.size(); ++i)
    if (pulses.values[i] < 60.0F) pulses.values[i] = 53.0F;
  ASSERT_GT(std::count(pulses.values.begin(), pulses.values.end(), 53.0F), 5'000);
  EXPECT_TRUE(stuck(pulses).empty());
  for (std::size_t i = 0; i < 5'000; ++i) pulses.values[i] = 52.0F;  // a street lamp comes on
  EXPECT_TRUE(stuck(pulses).empty());
  // Dark before the first pulse alone, where nothing shows what the dark is like.
  pulses.time_s.resize(7'990);
  pulses.values.resize(7'990);
  EXPECT_TRUE(stuck(pulses).empty());
}

TEST(StuckRuns, FlickerIsNoNoise) {
  // Of a coarse converter, sampled at about its own rate: it stands still at its nodes.
  const auto flickering = [](double rate_hz) {
    Random random(13);
    Samples samples;
    for (int k = 0; k < 8'000; ++k) {
      const double time_s = k / rate_hz;
      const double light = 2.0 * std::sin(2.0 * kPi * 100.03 * time_s);
      samples.time_s.push_back(time_s);
      samples.values.push_back(
          static_cast<float>(std::round(55.2 + light + random.normal(0.0, 0.02))));
    }
    return samples;
  };
  EXPECT_TRUE(stuck(flickering(200.0)).empty());
  EXPECT_TRUE(stuck(flickering(199.0)).empty());
  // The lamp goes off, and the little that is left of the record shows how quiet it is without.
  Samples off = flickering(131.0);
  std::fill(off.values.begin() + 7'800, off.values.end(), 55.0F);
  for (std::size_t i = 7'980; i < 8'000; i += 4) off.values[i] = 56.0F;
  EXPECT_TRUE(stuck(off).empty());
}

TEST(StuckRuns, FewerDigitsAboveADecadeAreNoHang) {
  Random random(12);
  Samples samples;
  for (int k = 0; k < 20'000; ++k) {
    const double level = k < 15'000 ? 0.95 : 1.05;  // three digits: steps of 0.001, then 0.01
    const double value = level + random.normal(0.0, 0.002);
    const double step = value < 1.0 ? 0.001 : 0.01;
    samples.time_s.push_back(1e-3 * k);
    samples.values.push_back(static_cast<float>(step * std::round(value / step)));
  }
  EXPECT_TRUE(stuck(samples).empty());
}

TEST(StuckRuns, ValuesHeldByTheRuleAreNoHang) {
  Samples samples = samples_with(kNoise, 0.0);
  for (std::size_t i = 0; i < samples.values.size(); ++i)
    samples.values[i] = samples.values[i - i % 200];  // a sensor of 5 Hz in a record of 1 kHz
  EXPECT_TRUE(stuck(samples).empty());
}

TEST(StuckRuns, TracesWithNothingToTellHaveNone) {
  EXPECT_TRUE(stuck({}).empty());
  EXPECT_TRUE(stuck({{0.0}, {1.0F}}).empty());
  Samples constant = samples_with(0.0, 0.0);
  std::fill(constant.values.begin(), constant.values.end(), 2.0F);
  EXPECT_TRUE(stuck(constant).empty());
}

PowerTrace conditioned(const Samples& samples, PowerQuantity quantity = PowerQuantity::power_w) {
  Site site;
  site.photodiodes.resize(1);
  site.photodiodes[0].responsivity_a_per_w = 1.0;
  site.photodiodes[0].transimpedance_v_per_a = 1.0;
  if (quantity == PowerQuantity::counts) site.photodiodes[0].volts_per_count = 1.0;
  if (quantity == PowerQuantity::voltage_v) site.photodiodes[0].full_scale_v = 5e3;
  PhotodiodeRecording recording;
  recording.quantity = quantity;
  recording.ids = {""};
  recording.time_s = samples.time_s;
  recording.values = {samples.values};
  return condition(recording, site).at(0);
}

TEST(Condition, AHangBecomesAGapAndIsCountedAsStuck) {
  Samples samples = samples_with(kNoise, 0.0);
  hang(samples, 10'000, 1'500);
  const PowerTrace trace = conditioned(samples);
  EXPECT_EQ(trace.rejected, (std::map<std::string, std::int64_t>{{"stuck", 1'501}}));
  ASSERT_EQ(trace.time_s.size(), 20'000U - 1'501U);
  EXPECT_DOUBLE_EQ(trace.time_s[9'998], 9.998);
  EXPECT_DOUBLE_EQ(trace.time_s[9'999], 11.5);
}

// Zeros from a moment on, or in between, whatever is known of the converter's range.
TEST(Condition, AnUnpluggedPhotodiodeIsStuckAndNotClipped) {
  for (const PowerQuantity quantity :
       {PowerQuantity::power_w, PowerQuantity::voltage_v, PowerQuantity::counts})
    for (const std::size_t until : {13'000, 20'000})
      for (const std::size_t again : {0, 60}) {
        Samples samples = samples_with(kNoise, quantity == PowerQuantity::counts ? 1.0 : 0.0);
        std::fill(samples.values.begin() + 7'800,
                  samples.values.begin() + static_cast<std::ptrdiff_t>(until), 0.0F);
        std::fill_n(samples.values.begin() + 3'000, again, 0.0F);
        const PowerTrace trace = conditioned(samples, quantity);
        EXPECT_EQ(trace.rejected, (std::map<std::string, std::int64_t>{
                                      {"stuck", static_cast<std::int64_t>(until - 7'800 + again)}}))
            << static_cast<int>(quantity) << " until " << until << ", again " << again;
      }
}

// The dark of an amplifier whose offset is below the range, at 0.
TEST(Condition, ADarkBelowTheConvertersEndIsClippedAndNotStuck) {
  for (const double offset : {53.0, 55.0, 80.0}) {
    Samples samples = samples_with(kNoise, 0.0);
    for (float& value : samples.values) value = std::max(value - static_cast<float>(offset), 0.0F);
    const PowerTrace trace = conditioned(samples);
    EXPECT_GT(trace.rejected.at("clipped"), 100) << offset;
    EXPECT_EQ(trace.rejected.count("stuck"), 0U) << offset;
  }
}

TEST(Condition, AFlatTopIsClippedAndNotStuck) {
  Samples samples = samples_with(kNoise, 0.0);
  for (float& value : samples.values) value = std::min(value, 800.0F);
  const PowerTrace trace = conditioned(samples);
  EXPECT_GT(trace.rejected.at("clipped"), 100);
  EXPECT_EQ(trace.rejected.count("stuck"), 0U);
  // 1e5 / (r^2 + 36) is brighter than 800 - 53 within 9.89 m, 0.66 s before each is past.
  ASSERT_EQ(trace.clipped.size(), 2U);
  for (const double past_s : {8.0, 16.0}) {
    const ClippedTime& time = trace.clipped[past_s > 8.0 ? 1 : 0];
    EXPECT_NEAR(time.from_s, past_s - 9.89 / 15.0, 0.01);
    EXPECT_NEAR(time.to_s, past_s, 0.005);
  }
}

TEST(Condition, LightHeldIntoTheDarkIsNoPass) {
  Samples samples = samples_with(kNoise, 0.0);
  hang(samples, 7'200, 4'000);
  const PowerTrace trace = conditioned(samples);
  const std::vector<PowerPass> passes = find_passes(trace);
  ASSERT_EQ(passes.size(), 2U);
  EXPECT_LT(passes[0].to_s, 7.25);
  EXPECT_TRUE(passes[0].cut_off);
  EXPECT_NEAR(passes[1].to_s, 16.0, 0.1);
}

}  // namespace
}  // namespace vildar
