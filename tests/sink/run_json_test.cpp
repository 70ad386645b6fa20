#include <nlohmann/json.hpp>

#include "sink/run_summary.h"
#include "sink/support.h"

namespace vildar {
namespace {

using nlohmann::json;
using test::Folder;

TEST(InputFile, HashesOfTheStandardsVectors) {
  const Folder folder;
  std::ofstream(folder / "abc") << "abc";
  std::ofstream(folder / "empty");
  const InputFile abc = describe_input("clip", folder / "abc");
  EXPECT_EQ(abc.sha256, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(abc.size_bytes, 3u);
  EXPECT_EQ(abc.role, "clip");
  EXPECT_EQ(describe_input("site", folder / "empty").sha256,
            "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

TEST(InputFile, AMillionLettersOverSeveralReads) {
  // The long vector of FIPS 180: one million times "a", several reads long.
  const Folder folder;
  std::ofstream(folder / "a") << std::string(1000000, 'a');
  EXPECT_EQ(describe_input("clip", folder / "a").sha256,
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(InputFile, WhatCannotBeReadIsAnInputErrorThatNamesIt) {
  const Folder folder;
  for (const char* name : {"absent.mp4", "."}) {
    try {
      describe_input("clip", folder / name);
      FAIL() << name;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find((folder / name).string()), std::string::npos);
    }
  }
}

RunSummary json_summary() {
  RunSummary run;
  run.version = "0.1.0";
  run.inputs = {{"clip", "a \"b\".mp4", 12, "ff"}};
  run.clip = ClipSummary{"mp4", "h264", "yuv420p", 1920, 1080, 0, 30.0, 12.5};
  run.traces = {
      {"pd0", 1000.0, 3e-10, 2e-8, 1e-12, 0.0, 1e-9, 50.1, {{1.5, 4.25, 200.0, 0.3, 0.02}}, 5e-8}};
  run.settings_yaml = "version: 1\nroad: {kind: straight}\n";
  run.options = {{"annotate", "true"}};
  run.counts = {{"frames_read", 375}, {"frames_damaged", 2}};
  run.rejected_samples = {{"pd0", {{"nan", 3}}}};
  run.timings_s = {{"detect", 1.25}};
  run.warnings = {"clip.mp4: frame 17: cannot be decoded; left out"};
  run.damaged = true;
  return run;
}

TEST(RunJson, ReadsBackAsWhatWasWritten) {
  const Folder folder;
  const std::vector<VehicleResult> vehicles{test::measured_vehicle(), test::withheld_vehicle()};
  write_run_json(folder / "run.json", json_summary(), vehicles).commit();
  const json run = json::parse(test::text_of(folder / "run.json"));
  EXPECT_EQ(test::text_of(folder / "run.json"), run_json_text(json_summary(), vehicles));
  EXPECT_EQ(run["version"], "0.1.0");
  EXPECT_EQ(run["damaged"], true);
  EXPECT_EQ(run["inputs"][0]["path"], "a \"b\".mp4");
  EXPECT_EQ(run["inputs"][0]["size_bytes"], 12);
  EXPECT_EQ(run["clip"]["width_px"], 1920);
  EXPECT_EQ(run["counts"]["frames_damaged"], 2);
  EXPECT_EQ(run["photodiodes"][0]["id"], "pd0");
  EXPECT_EQ(run["photodiodes"][0]["noise_w"], 3e-10);
  EXPECT_EQ(run["photodiodes"][0]["mains_hz"], 50.1);
  const auto& pulsing = run["photodiodes"][0]["pulsing_lamps"];
  ASSERT_EQ(pulsing.size(), 1U);
  EXPECT_EQ(pulsing[0]["from_s"], 1.5);
  EXPECT_EQ(pulsing[0]["to_s"], 4.25);
  EXPECT_EQ(pulsing[0]["frequency_hz"], 200.0);
  EXPECT_EQ(pulsing[0]["duty"], 0.3);
  EXPECT_EQ(pulsing[0]["duty_std"], 0.02);
  EXPECT_EQ(run["photodiodes"][0]["switched_w"], 5e-8);
  EXPECT_EQ(run["rejected_samples"]["pd0"]["nan"], 3);
  EXPECT_EQ(run["settings"]["site_yaml"], json_summary().settings_yaml);
  EXPECT_EQ(run["warnings"].size(), 1u);
  const json& measured = run["vehicles"][0];
  EXPECT_EQ(measured["status"], "measured");
  EXPECT_EQ(measured["speed_mps"], 14.5);
  EXPECT_EQ(measured["sensors"], (json{"camera", "photodiode"}));
  EXPECT_EQ(measured["methods"][0]["k_source"], "bearings");
  EXPECT_EQ(measured["methods"][1]["status"], "withheld:outside_model");
  const json& withheld = run["vehicles"][1];
  EXPECT_EQ(withheld["status"], "withheld:too_short");
  for (const char* key : {"speed_mps", "speed_kmh", "t_ref_s", "range_ref_m", "method"})
    EXPECT_FALSE(withheld.contains(key)) << key;
}

TEST(RunJson, NumbersThatAreNotFiniteAndBytesThatAreNoTextDoNotBreakIt) {
  RunSummary run = json_summary();
  run.warnings = {"caf\xE9.mp4"};
  VehicleResult vehicle = test::measured_vehicle();
  vehicle.speed.hi95_mps = INFINITY;
  const json parsed = json::parse(run_json_text(run, std::vector<VehicleResult>{vehicle}));
  EXPECT_EQ(parsed["warnings"][0], "caf\xEF\xBF\xBD.mp4");
  EXPECT_FALSE(parsed["vehicles"][0].contains("speed_hi95_mps"));
}

TEST(RunJson, NoVehicleIsAnEmptyList) {
  const json run = json::parse(run_json_text({}, {}));
  EXPECT_TRUE(run["vehicles"].is_array());
  EXPECT_TRUE(run["vehicles"].empty());
  EXPECT_FALSE(run.contains("clip"));
}

}  // namespace
}  // namespace vildar
