#include "evaluate/requirement.h"

#include <gtest/gtest.h>

#include "core/error.h"

namespace vildar {
namespace {

Evaluation evaluation_of_ten() {
  Evaluation evaluation;
  evaluation.in_view = 10;
  evaluation.matched = 9;
  evaluation.measured = 8;
  evaluation.withheld["too_short"] = 1;
  evaluation.missed = 1;
  evaluation.false_speeds = 2;
  evaluation.methods["fused"].speed.kmh.max = 2.5;
  return evaluation;
}

bool holds(const std::string& text) {
  const Requirement requirement = parse_requirement(text);
  return check(std::span(&requirement, 1), evaluation_of_ten()).front().holds;
}

TEST(Requirement, EveryOperatorComparesAsItReads) {
  EXPECT_TRUE(holds("recall>=0.8"));
  EXPECT_FALSE(holds("recall>0.8"));
  EXPECT_TRUE(holds("recall<=0.8"));
  EXPECT_FALSE(holds("recall<0.8"));
  EXPECT_TRUE(holds("precision == 0.8"));
  EXPECT_FALSE(holds("precision==0.81"));
  EXPECT_TRUE(holds(" false < 3 "));
  EXPECT_TRUE(holds("detection_recall>=9e-1"));
  EXPECT_TRUE(holds("withheld==1"));
  EXPECT_TRUE(holds("fused.max_error_kmh<=3"));
  EXPECT_FALSE(holds("fused.max_error_kmh<=2"));
}

TEST(Requirement, WhatHasNoValueDoesNotHold) {
  EXPECT_FALSE(holds("coverage>=0"));
  EXPECT_FALSE(holds("hota<=1"));
  EXPECT_FALSE(holds("ml_photodiode.false==0"));  // a method that the run has no row of
  const Requirement requirement = parse_requirement("coverage>=0");
  const auto results = check(std::span(&requirement, 1), evaluation_of_ten());
  EXPECT_NE(to_string(results.front()).find("does not hold"), std::string::npos);
}

TEST(Requirement, NamesTheMetricAndItsValue) {
  const Requirement requirement = parse_requirement("recall>=0.95");
  const auto results = check(std::span(&requirement, 1), evaluation_of_ten());
  EXPECT_EQ(to_string(results.front()), "recall>=0.95: does not hold, it is 0.8");
}

TEST(Requirement, EveryNameAskedForByScriptsIsKnown) {
  for (const char* name : {"recall",
                           "precision",
                           "max_error_kmh",
                           "max_error_percent",
                           "mean_abs_error_kmh",
                           "bias_kmh",
                           "coverage",
                           "share_within_limits",
                           "false",
                           "missed",
                           "withheld",
                           "hota",
                           "deta",
                           "assa",
                           "loca",
                           "mota",
                           "motp",
                           "idf1",
                           "id_switches",
                           "p95_abs_error_kmh",
                           "median_abs_error_percent",
                           "range_rms_m",
                           "power_slope_photodiode.coverage"})
    EXPECT_NO_THROW(parse_requirement(std::string(name) + ">=0")) << name;
}

TEST(Requirement, RefusesWhatItDoesNotUnderstand) {
  const auto refused = [](const char* text, const char* part) {
    try {
      parse_requirement(text);
      ADD_FAILURE() << text << " was accepted";
    } catch (const ConfigError& error) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
  };
  refused("recal>=0.9", "did you mean \"recall\"?");
  refused("fusd.bias_kmh<=1", "did you mean \"fused.bias_kmh\"?");
  refused("completely_unknown>=1", "no metric is called");
  refused("recall", "none of the operators");
  refused("recall=0.9", "none of the operators");
  refused("recall>=", "is not a finite number");
  refused("recall>=95%", "is not a finite number");
  refused("recall>=nan", "is not a finite number");
}

}  // namespace
}  // namespace vildar
