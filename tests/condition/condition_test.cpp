#include "condition/condition.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/error.h"
#include "core/quantity.h"
#include "core/random.h"

namespace vildar {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

Site site_with(std::vector<std::string> ids) {
  Site site;
  site.file = "site.yaml";
  for (std::string& id : ids) {
    PhotodiodeSite photodiode;
    photodiode.id = std::move(id);
    site.photodiodes.push_back(std::move(photodiode));
  }
  return site;
}

PhotodiodeRecording recording_of(PowerQuantity quantity, std::vector<double> time_s,
                                 std::vector<float> values) {
  PhotodiodeRecording recording;
  recording.quantity = quantity;
  recording.ids = {""};
  recording.rows_read = static_cast<std::int64_t>(time_s.size());
  recording.time_s = std::move(time_s);
  recording.values = {std::move(values)};
  return recording;
}

std::vector<double> steady_times(std::size_t count) {
  std::vector<double> time_s(count);
  for (std::size_t k = 0; k < count; ++k) time_s[k] = 1e-3 * static_cast<double>(k);
  return time_s;
}

using Counts = std::map<std::string, std::int64_t>;

TEST(Condition, ChannelsFindTheirPhotodiodeByName) {
  const Site site = site_with({"left", "right", "spare"});
  PhotodiodeRecording recording = recording_of(PowerQuantity::power_w, {0, 1, 2}, {1, 2, 3});
  EXPECT_EQ(condition(recording, site).at(0).photodiode_id, "left") << "without a name: the first";
  recording.ids = {"right", "left"};
  recording.values.push_back({4, 5, 6});
  const std::vector<PowerTrace> traces = condition(recording, site);
  ASSERT_EQ(traces.size(), 2U);
  EXPECT_EQ(traces[0].photodiode, 0) << "in the site's order, whatever the recording's";
  EXPECT_EQ(traces[1].photodiode, 1);
  EXPECT_EQ(traces[0].power_w, (std::vector<float>{4, 5, 6}));
}

std::string error_of(const PhotodiodeRecording& recording, const Site& site) {
  try {
    condition(recording, site);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Condition, ChannelsThatFitNoPhotodiodeAreRefused) {
  PhotodiodeRecording recording = recording_of(PowerQuantity::power_w, {0, 1}, {1, 2});
  EXPECT_NE(error_of(recording, site_with({})).find("no photodiode"), std::string::npos);
  recording.ids = {"pd7"};
  const std::string error = error_of(recording, site_with({"pd0", "pd1"}));
  for (const char* part : {"pd7", "pd0, pd1", "site.yaml"})
    EXPECT_NE(error.find(part), std::string::npos) << error;
}

TEST(Condition, QuantitiesBecomeWattsByTheSitesFactors) {
  Site site = site_with({"pd0"});
  PhotodiodeSite& pd = site.photodiodes[0];
  pd.responsivity_a_per_w = 0.5;
  pd.transimpedance_v_per_a = 1e6;
  pd.volts_per_count = 1e-4;
  const auto first_w = [&](PowerQuantity quantity) {
    return condition(recording_of(quantity, {0, 1, 2}, {3, 5, 4}), site).at(0).power_w.at(0);
  };
  constexpr float kFloat = 1e-6F;
  EXPECT_EQ(first_w(PowerQuantity::power_w), 3.0F);
  EXPECT_NEAR(first_w(PowerQuantity::current_a) / 6.0F, 1.0F, kFloat);
  EXPECT_NEAR(first_w(PowerQuantity::voltage_v) / 6e-6F, 1.0F, kFloat);
  EXPECT_NEAR(first_w(PowerQuantity::counts) / 6e-10F, 1.0F, kFloat);
  pd.volts_per_count.reset();
  pd.full_scale_v = 10.0;  // samples are fractions of full scale, as in a sound file
  PhotodiodeRecording sound = recording_of(PowerQuantity::counts, {0, 1, 2}, {0.25F, 0.5F, 1.001F});
  sound.shares = true;
  const PowerTrace fraction = condition(std::move(sound), site).at(0);
  EXPECT_NEAR(fraction.power_w.at(0) / 5e-6F, 1.0F, kFloat);
}

TEST(Condition, AFactorThatIsMissingIsNamed) {
  Site site = site_with({"pd0"});
  const auto error = [&](PowerQuantity quantity) {
    return error_of(recording_of(quantity, {0, 1}, {1, 2}), site);
  };
  EXPECT_NE(error(PowerQuantity::counts).find("photodiodes[0].volts_per_count"), std::string::npos);
  EXPECT_NE(error(PowerQuantity::voltage_v).find("photodiodes[0].transimpedance_v_per_a"),
            std::string::npos);
  EXPECT_NE(error(PowerQuantity::current_a).find("photodiodes[0].responsivity_a_per_w"),
            std::string::npos);
  EXPECT_EQ(error(PowerQuantity::power_w), "no error");
  // Full scale says what shares of it are, not what a count is.
  site.photodiodes[0].full_scale_v = 3.3;
  EXPECT_NE(error(PowerQuantity::counts).find("photodiodes[0].volts_per_count"), std::string::npos);
}

TEST(Condition, BadSamplesAreLeftOutAndCountedByReason) {
  const double wild_s = 1e6;
  const PowerTrace trace =
      condition(recording_of(PowerQuantity::power_w, {0, 1, 2, wild_s, 3, 3, 0.5, 4, 5, 6},
                             {0, 1, kNan, 9, 3, 8, 7, 4, 5, -6}),
                site_with({"pd0"}))
          .at(0);
  EXPECT_EQ(trace.time_s, (std::vector<double>{0, 1, 3, 4, 5, 6}));
  EXPECT_EQ(trace.power_w, (std::vector<float>{0, 1, 3, 4, 5, -6}));
  EXPECT_EQ(trace.rejected, (Counts{{"not_a_number", 1}, {"out_of_order", 2}, {"repeated", 1}}));
}

/// Length of the longest strictly increasing selection, by the quadratic recurrence.
std::size_t longest_selection(const std::vector<double>& time_s) {
  std::vector<std::size_t> best(time_s.size(), 1);
  for (std::size_t i = 0; i < time_s.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (time_s[j] < time_s[i]) best[i] = std::max(best[i], best[j] + 1);
  return time_s.empty() ? 0 : *std::max_element(best.begin(), best.end());
}

TEST(Condition, AsFewSamplesAsPossibleAreLeftOutToGetOrder) {
  Random random(6);
  for (int trial = 0; trial < 300; ++trial) {
    std::vector<double> time_s;
    for (int k = 0; k < 40; ++k)
      time_s.push_back(random.uniform() < 0.7 ? k : std::floor(random.uniform(-10.0, 60.0)));
    std::vector<float> values(time_s.size());
    std::iota(values.begin(), values.end(), 0.0F);
    const PowerTrace trace =
        condition(recording_of(PowerQuantity::power_w, time_s, values), site_with({"pd0"})).at(0);
    ASSERT_EQ(trace.time_s.size(), longest_selection(time_s));
    for (std::size_t i = 0; i < trace.time_s.size(); ++i) {
      ASSERT_EQ(trace.time_s[i], time_s[static_cast<std::size_t>(trace.power_w[i])])
          << "a value left its stamp";
      if (i > 0) {
        ASSERT_GT(trace.time_s[i], trace.time_s[i - 1]);
      }
    }
    std::int64_t rejected = 0;
    for (const auto& [reason, count] : trace.rejected) rejected += count;
    ASSERT_EQ(rejected + static_cast<std::int64_t>(trace.time_s.size()), 40);
  }
}

/// A noisy wave cut off at `ceiling`; how many samples are.
std::vector<float> cut_wave(double ceiling, std::int64_t& cut) {
  Random random(8);
  std::vector<float> values;
  cut = 0;
  for (int k = 0; k < 2000; ++k) {
    const double value =
        1000.0 + 1000.0 * std::sin(2.0 * kPi * k / 1000.0) + random.normal(0.0, 5.0);
    cut += value >= ceiling ? 1 : 0;
    values.push_back(static_cast<float>(std::min(value, ceiling)));
  }
  return values;
}

TEST(Condition, AFlatTopIsClippedWhereNoRangeIsKnown) {
  std::int64_t cut = 0;
  const std::vector<float> values = cut_wave(1700.0, cut);
  const PowerTrace trace =
      condition(recording_of(PowerQuantity::power_w, steady_times(values.size()), values),
                site_with({"pd0"}))
          .at(0);
  // Single samples at the ceiling, on the noisy edge of a flat top, are fewer than 5 in a row.
  EXPECT_NEAR(static_cast<double>(trace.rejected.at("clipped")), static_cast<double>(cut),
              0.05 * static_cast<double>(cut));
  std::int64_t none = 0;
  const std::vector<float> free = cut_wave(1e9, none);
  EXPECT_TRUE(condition(recording_of(PowerQuantity::power_w, steady_times(free.size()), free),
                        site_with({"pd0"}))
                  .at(0)
                  .rejected.empty());
  const std::vector<float> constant(100, 2.0F);
  EXPECT_TRUE(condition(recording_of(PowerQuantity::power_w, steady_times(100), constant),
                        site_with({"pd0"}))
                  .at(0)
                  .rejected.empty());
}

TEST(Condition, AFlatBottomIsClippedButNotTheDarkOfACoarseConverter) {
  const auto clipped = [](std::vector<float> values) {
    const std::size_t count = values.size();
    const PowerTrace trace =
        condition(recording_of(PowerQuantity::power_w, steady_times(count), std::move(values)),
                  site_with({"pd0"}))
            .at(0);
    const auto found = trace.rejected.find("clipped");
    return found == trace.rejected.end() ? 0.0 : static_cast<double>(found->second);
  };
  std::int64_t cut = 0;
  std::vector<float> turned = cut_wave(1700.0, cut);
  for (float& value : turned) value = 3000.0F - value;
  EXPECT_NEAR(clipped(turned), static_cast<double>(cut), 0.05 * static_cast<double>(cut));
  std::vector<float> coarse;
  for (int k = 0; k < 2000; ++k)
    coarse.push_back(static_cast<float>(std::round(k > 1500 ? 0.02 * (k - 1500) : 1.0)));
  EXPECT_EQ(clipped(coarse), 0.0);
}

// White noise through two low passes of one pole each.
TEST(Condition, AFlatBottomIsLeftOutWhereNoiseIsSlow) {
  constexpr int kSamples = 60000, kCutFrom = 20000, kCutTo = 26000;
  constexpr double kRate_hz = 2000.0;
  Random random(9);
  for (const double pole_hz : {10.0, 20.0, 40.0, 200.0}) {
    const double kept = std::exp(-2.0 * kPi * pole_hz / kRate_hz);
    std::vector<double> time_s(kSamples);
    std::vector<float> values(kSamples);
    double once = 0.0, twice = 0.0;
    for (std::size_t k = 0; k < kSamples; ++k) {
      once = kept * once + (1.0 - kept) * random.normal();
      twice = kept * twice + (1.0 - kept) * once;
      time_s[k] = static_cast<double>(k) / kRate_hz;
      const bool cut = k >= kCutFrom && k < kCutTo;
      values[k] = static_cast<float>(cut ? 0.0 : 5.0 + twice);
    }
    const PowerTrace trace =
        condition(recording_of(PowerQuantity::power_w, std::move(time_s), std::move(values)),
                  site_with({"pd0"}))
            .at(0);
    EXPECT_EQ(trace.rejected, (Counts{{"stuck", kCutTo - kCutFrom}})) << pole_hz << " Hz";
  }
}

TEST(Condition, WhatTheConvertersStepsHideStaysHiddenWhereFlickerIsTakenOut) {
  constexpr double kLevel = 100.25, kRate_hz = 20000.0;
  Random random(10);
  for (const double noise : {0.0, 0.1}) {
    std::vector<double> time_s;
    std::vector<float> values;
    for (int k = 0; k < 15 * static_cast<int>(kRate_hz); ++k) {
      const double at_s = k / kRate_hz;
      time_s.push_back(at_s);
      values.push_back(static_cast<float>(std::round(
          kLevel + 0.5 * std::sin(2.0 * kPi * 100.0 * at_s) + random.normal(0.0, noise))));
    }
    const PowerTrace trace =
        condition(recording_of(PowerQuantity::power_w, std::move(time_s), std::move(values)),
                  site_with({"pd0"}))
            .at(0);
    EXPECT_GT(trace.flicker_w, 0.1);
    EXPECT_LT(std::abs(trace.ambient_w - kLevel), 3.0 * trace.ambient_sigma_w) << noise;
    EXPECT_LT(trace.ambient_sigma_w, 0.5) << noise;
  }
}

TEST(Condition, TheDarkOfATraceWithoutNoiseIsNotClipped) {
  for (const double ambient_w : {0.0, 3e-7}) {
    std::vector<float> values;
    for (int k = 0; k < 3000; ++k)
      values.push_back(static_cast<float>(
          ambient_w + (k < 1000 || k >= 2000 ? 0.0 : 1e-7 * std::pow(1e-3 * k, 5.0))));
    const PowerTrace trace =
        condition(recording_of(PowerQuantity::power_w, steady_times(values.size()), values),
                  site_with({"pd0"}))
            .at(0);
    EXPECT_TRUE(trace.rejected.empty());
    EXPECT_NEAR(trace.ambient_w, ambient_w, 1e-13);
  }
}

TEST(Condition, SamplesAtEitherEndOfAKnownRangeAreClipped) {
  Site site = site_with({"pd0"});
  PhotodiodeSite& pd = site.photodiodes[0];
  pd.responsivity_a_per_w = 0.5;
  pd.transimpedance_v_per_a = 1e6;
  pd.full_scale_v = 2.0;
  const auto clipped = [&](PowerQuantity quantity, std::vector<float> values) {
    const std::size_t count = values.size();
    PhotodiodeRecording recording = recording_of(quantity, steady_times(count), std::move(values));
    recording.shares = true;  // counts without volts
    const PowerTrace trace = condition(std::move(recording), site).at(0);
    const auto found = trace.rejected.find("clipped");
    return found == trace.rejected.end() ? 0 : found->second;
  };
  EXPECT_EQ(clipped(PowerQuantity::voltage_v, {0.1F, 2.0F, 1.9F, -2.0F, 0.2F}), 2);
  EXPECT_EQ(clipped(PowerQuantity::counts, {0.1F, 1.0F, 0.9F, -1.0F, 0.2F}), 2)
      << "fractions of full scale";
  pd.full_scale_v.reset();
  pd.volts_per_count = 1e-3;
  EXPECT_EQ(clipped(PowerQuantity::counts, {100, 4095, 3000, 0, 200, 4095}), 3) << "12 bits";
  EXPECT_EQ(clipped(PowerQuantity::counts, {100, 32767, 3000, -32768, 200}), 2)
      << "16 bits, signed";
  EXPECT_EQ(clipped(PowerQuantity::counts, {100, 4000, 3000, 1, 200}), 0);
}

TEST(Condition, ATraceWithNothingGoodIsEmptyAndCounted) {
  const PowerTrace trace =
      condition(recording_of(PowerQuantity::power_w, {0, 1}, {kNan, kNan}), site_with({"pd0"}))
          .at(0);
  EXPECT_TRUE(trace.time_s.empty());
  EXPECT_EQ(trace.rejected, (Counts{{"not_a_number", 2}}));
}

}  // namespace
}  // namespace vildar
