#include "synth/scenario.h"

#include <cmath>
#include <filesystem>
#include <fstream>

#include <algorithm>

#include <gtest/gtest.h>

#include "core/error.h"

namespace vildar {
namespace {

namespace fs = std::filesystem;

const char* const kSite =
    "site:\n"
    "  camera:\n"
    "    image_size_px: [320, 180]\n"
    "    focal_px: [300.0, 300.0]\n"
    "    principal_px: [159.5, 89.5]\n"
    "    position_m: [0.0, 0.0, 5.0]\n"
    "    yaw_deg: 0.0\n"
    "    pitch_deg: -7.0\n"
    "    roll_deg: 0.0\n"
    "    exposure_s: 0.001\n"
    "  road:\n"
    "    kind: straight\n"
    "    lanes:\n"
    "      - {id: near, lateral_m: -3.0, direction: oncoming}\n"
    "      - {id: far, lateral_m: -6.5, direction: receding}\n";

class LoadScenario : public ::testing::Test {
 protected:
  LoadScenario()
      : folder_(fs::path(::testing::TempDir()) /
                ("scenario_" +
                 std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()))) {
    fs::create_directories(folder_);
  }
  ~LoadScenario() override { fs::remove_all(folder_); }

  fs::path written(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  Scenario loaded(const std::string& text) const { return load_scenario(written("s.yaml", text)); }

  /// The problems of a scenario, as one text.
  std::string problems(const std::string& text) const {
    try {
      loaded(text);
    } catch (const ConfigError& error) {
      std::string all;
      for (const Problem& problem : error.problems()) all += to_string(problem) + "\n";
      return all;
    }
    return "";
  }

  fs::path folder_;
};

TEST_F(LoadScenario, ReadsWhatIsThereAndKeepsTheUsualForTheRest) {
  const Scenario scenario =
      loaded("duration_s: 4\nframe_rate_hz: 50\nseed: 99\nwet_road: true\n" + std::string(kSite) +
             "vehicles:\n"
             "  - {id: a, lane: near, speed_mps: 20, range_at_zero_m: 60, lamp_height_m: 0.7}\n"
             "  - {id: b, kind: motorcycle, lane: far, speed_mps: 10, range_at_zero_m: 8}\n"
             "street_lamps: [{position_m: [40, 5, 8], intensity_cd: 500}]\n"
             "image: {full_well_e: 5000, read_noise_e: 2}\n"
             "encoder: {codec: ffv1}\n"
             "photodiode: {rate_hz: 2000, snr_db: 30}\n");
  EXPECT_EQ(scenario.duration_s, 4.0);
  EXPECT_EQ(scenario.seed, 99u);
  EXPECT_TRUE(scenario.wet_road);
  ASSERT_EQ(scenario.vehicles.size(), 2u);
  EXPECT_EQ(scenario.vehicles[0].along_at_zero_m, 60.0);
  EXPECT_EQ(scenario.vehicles[0].lamp_height_m, 0.7);
  EXPECT_EQ(scenario.vehicles[0].lamps, VehicleLamps::head);
  EXPECT_EQ(scenario.vehicles[1].lane, 1);
  EXPECT_EQ(scenario.vehicles[1].lamps, VehicleLamps::tail);
  EXPECT_EQ(scenario.vehicles[1].lamp_separation_m, 0.0);
  EXPECT_EQ(scenario.street_lamps.at(0).intensity_cd, 500.0);
  EXPECT_EQ(scenario.image.full_well_e, 5000.0);
  EXPECT_EQ(scenario.encoder.codec, ClipCodec::ffv1);
  EXPECT_EQ(*scenario.photodiode.snr_db, 30.0);
}

TEST_F(LoadScenario, FindsTheSiteFileBesideIt) {
  std::string site = kSite;
  site = "version: 1\n" + site.substr(site.find('\n') + 1);
  for (std::size_t at = site.find("\n  "); at != std::string::npos; at = site.find("\n  ", at + 1))
    site.erase(at + 1, 2);
  written("place.yaml", site);
  const Scenario scenario = loaded("duration_s: 1\nsite: place.yaml\n");
  EXPECT_EQ(scenario.site.camera.value().width_px, 320);
  EXPECT_NE(problems("duration_s: 1\nsite: nowhere.yaml\n").find("nowhere.yaml"),
            std::string::npos);
}

TEST_F(LoadScenario, OnACurveTheRangeIsX) {
  std::string site = kSite;
  site.replace(site.find("kind: straight"), 14,
               "kind: curved\n    straight_m: 10\n    radius_m: 50\n    turn: left");
  const std::string head =
      "duration_s: 1\n" + site + "vehicles:\n  - {id: a, lane: near, speed_mps: 9, ";
  // The near lane's own radius is 53 m.
  EXPECT_NEAR(loaded(head + "range_at_zero_m: 40}\n").vehicles[0].along_at_zero_m,
              10.0 + 53.0 * std::asin(30.0 / 53.0), 1e-12);
  EXPECT_EQ(loaded(head + "along_at_zero_m: 90}\n").vehicles[0].along_at_zero_m, 90.0);
  EXPECT_NE(problems(head + "range_at_zero_m: 70}\n").find("never reaches"), std::string::npos);
  EXPECT_NE(problems(head + "range_at_zero_m: 7, along_at_zero_m: 7}\n").find("keep one"),
            std::string::npos);
}

TEST_F(LoadScenario, EveryProblemIsNamedAtOnce) {
  const std::string all =
      problems("duration_s: -4\nframerate_hz: 25\n" + std::string(kSite) +
               "vehicles:\n"
               "  - {id: a, lane: nearr, speed_mps: 20, range_at_zero_m: 60}\n"
               "  - {id: b, lane: near, speed_mps: -1, range_at_zero_m: 60}\n"
               "  - {id: b, lane: near, speed_mps: 1, range_at_zero_m: 60, lamp_hight_m: 1}\n"
               "image: {wing_share: 1.5}\n"
               "encoder: {codec: h264, crf: 60}\n");
  for (const char* part :
       {"s.yaml:1", "duration_s", "s.yaml:2", "frame_rate_hz", "nearr", "near, far", "speed_mps",
        "another vehicle", "lamp_height_m", "wing_share", "crf"})
    EXPECT_NE(all.find(part), std::string::npos) << part << " in\n" << all;
  EXPECT_GE(std::count(all.begin(), all.end(), '\n'), 8) << all;
}

TEST_F(LoadScenario, EachRuleOnItsOwn) {
  const std::string good = "duration_s: 1\n" + std::string(kSite);
  ASSERT_EQ(problems(good), "");
  const struct {
    std::string text, part;
  } cases[] = {
      {kSite, "duration_s"},
      {"duration_s: 1\n", "site"},
      {good + "photodiode: {rate_hz: 50}\n", "rate_hz"},
      {good + "photodiode: {snr_db: 5, noise_w: 1.0e-9}\n", "keep one"},
      {good + "encoder: {codec: ffv1, crf: 3}\n", "lossless"},
      {good + "encoder: {bitrate_bps: 500000, crf: 3}\n", "keep one"},
      {good + "encoder: {codec: mpeg2}\n", "mpeg2"},
      {good + "street_lamps: [{position_m: [1, 2], intensity_cd: 4}]\n", "position_m"},
      {good + "vehicles: [{id: \"a,b\", lane: near, speed_mps: 1, range_at_zero_m: 5}]\n",
       "columns"},
      {good + "vehicles: [{id: a, lane: near, range_at_zero_m: 5}]\n", "speed_mps"},
      {good + "vehicles: [{id: a, lane: near, speed_mps: 5}]\n", "range_at_zero_m"},
      {good + "vehicles: [{id: a, kind: bus, lane: near, speed_mps: 5, range_at_zero_m: 5}]\n",
       "bus"},
      {good + "seed: -1\n", "seed"},
  };
  for (const auto& [text, part] : cases) {
    const std::string found = problems(text);
    EXPECT_NE(found.find(part), std::string::npos) << text << "gave: " << found;
  }
}

TEST_F(LoadScenario, WhatTheRendererNeedsOfTheSite) {
  std::string site = kSite;
  site.erase(site.find("    exposure_s"), std::string("    exposure_s: 0.001\n").size());
  EXPECT_NE(problems("duration_s: 1\n" + site).find("exposure_s"), std::string::npos);
  const std::string with_photodiode =
      "duration_s: 1\n" + std::string(kSite) + "  photodiode: {position_m: [0, 0, 5]}\n";
  EXPECT_NE(problems(with_photodiode).find("channel"), std::string::npos);
  EXPECT_EQ(problems(with_photodiode + "  channel: {gain_db: -42, path_loss_exponent: 2}\n"), "");
}

}  // namespace
}  // namespace vildar
