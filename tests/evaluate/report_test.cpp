#include "evaluate/report.h"

#include <gtest/gtest.h>

#include <sstream>

#include <nlohmann/json.hpp>

#include "evaluate/hand_made.h"

namespace vildar {
namespace {

Evaluation small_night() {
  RunFolder run;
  run.vehicles = {measured(run_at("1", 101, 0, 29), 1.0, 20.5), run_at("2", 300, 0, 39)};
  run.vehicles[0].methods = {{"fused", {StatedSpeed{1.0, 20.5, {}, {}, {}}, ""}}};
  run.notes = {"a note"};
  return evaluate({truth_at("car", 100, 0, 39), truth_at("van \xff", 300, 0, 39)}, run);
}

TEST(JsonReport, HoldsWhatTheEvaluationHolds) {
  const Requirement requirement = parse_requirement("recall>=0.95");
  const Evaluation evaluation = small_night();
  const auto json =
      nlohmann::json::parse(json_report(evaluation, check(std::span(&requirement, 1), evaluation)));
  EXPECT_EQ(json.at("matched_by"), "image");
  ASSERT_EQ(json.at("vehicles").size(), 2U);
  const auto& car = json.at("vehicles")[0];
  EXPECT_EQ(car.at("vehicle_id"), "car");
  EXPECT_EQ(car.at("outcome"), "measured");
  EXPECT_NEAR(car.at("error_kmh").get<double>(), 1.8, 1e-9);
  EXPECT_EQ(car.at("inside_95"), true);
  EXPECT_EQ(json.at("vehicles")[1].at("withheld"), "too_short");
  EXPECT_EQ(json.at("withheld_by_reason").at("too_short"), 1);
  EXPECT_EQ(json.at("metrics").at("recall"), 0.5);
  EXPECT_TRUE(json.at("metrics").at("range_rms_m").is_null());
  EXPECT_NEAR(json.at("metrics").at("fused.bias_kmh").get<double>(), 1.8, 1e-9);
  EXPECT_EQ(json.at("requirements")[0].at("holds"), false);
  EXPECT_EQ(json.at("notes")[0], "a note");
}

TEST(TextReport, IsAlignedAndNamesEveryVehicle) {
  const std::string text = text_report(small_night(), {});
  std::istringstream lines(text);
  std::string header, car;
  std::getline(lines, header);
  std::getline(lines, car);
  // Numbers end where the heading of their column ends.
  const auto end_of = [](const std::string& line, const std::string& part) {
    return line.find(part) + part.size();
  };
  EXPECT_EQ(end_of(header, "error km/h"), end_of(car, "+1.80"));
  EXPECT_EQ(end_of(header, "run km/h"), end_of(car, "73.80"));
  EXPECT_EQ(header.find("track"), car.find("1 "));
  for (const char* part : {"withheld: too_short", "fused", "HOTA", "note: a note", "50.0 %"})
    EXPECT_NE(text.find(part), std::string::npos) << part;
  EXPECT_EQ(text.find(" \n"), std::string::npos);
}

TEST(TextReport, SaysWhenThereIsNothing) {
  EXPECT_NE(text_report(evaluate({}, {}), {}).find("neither truth nor run has a vehicle"),
            std::string::npos);
}

}  // namespace
}  // namespace vildar
