#include "synth/scenario.h"

#include <cmath>
#include <filesystem>
#include <fstream>

#include <algorithm>

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/quantity.h"

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
  const std::string found =
      problems("duration_s: 1\nsite: nowhere.yaml\nvehicles:\n  - {id: a, speed_mps: 20}\n");
  EXPECT_NE(found.find("nowhere.yaml"), std::string::npos);
  EXPECT_EQ(found.find("vehicles"), std::string::npos) << found;
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

TEST_F(LoadScenario, ReadsTheWholeWorld) {
  std::ofstream(folder_ / "spot.ies") << "IESNA:LM-63-2002\nTILT=NONE\n1 1000 1 3 1 1 2 0 0 0\n"
                                         "1 1 10\n0 45 90\n0\n500 300 0\n";
  const Scenario scenario = loaded(
      "duration_s: 4\nwet_road: true\ntraffic_side: left\nweather: {visibility_m: 200}\n"
      "shake: {yaw_std_deg: 0.1, pitch_std_deg: 0.2, frequency_hz: 4}\n"
      "frame_times: {jitter_s: 0.002, dropped_share: 0.01, dropped: [3, 9]}\n" +
      std::string(kSite) +
      "told_site:\n  photodiode: {position_m: [0, 0, 5]}\n"
      "vehicles:\n"
      "  - id: a\n    lane: near\n    speed_mps: 20\n    range_at_zero_m: 60\n"
      "    beam: low_beam\n    aim_pitch_deg: -0.5\n    beam_scale: 0.8\n"
      "    pulses: {frequency_hz: 200, duty: 0.3}\n"
      "    speed_changes: [{from_s: 1, acceleration_mps2: -2}]\n"
      "    lane_changes: [{from_s: 1, duration_s: 2, to: far}]\n"
      "    pitching: {amplitude_deg: 0.3, frequency_hz: 1.2, phase_deg: 90}\n"
      "  - {id: b, lane: near, speed_mps: 5, range_at_zero_m: 90, beam: spot.ies}\n"
      "  - {id: c, lane: near, speed_mps: 5, range_at_zero_m: 120, beam: lambertian,\n"
      "     half_power_angle_deg: 40, intensity_cd: 900}\n"
      "street_lamps: [{position_m: [40, 5, 8], intensity_cd: 500, flicker: 0.2}]\n"
      "signs: [{position_m: [50, 6, 3], width_m: 2, height_m: 1, luminance_cd_per_m2: 80}]\n"
      "image: {dark_e_per_s: 10, prnu: 0.01, bayer: true, glow_cd_per_m2: 0.1, own_lamps: true}\n"
      "encoder: {codec: mjpeg, quality: 4}\n");
  EXPECT_NEAR(scenario.extinction_per_m, 3.912 / 200.0, 1e-12);
  EXPECT_NEAR(scenario.shake.pitch_std_rad, 0.2 * kPi / 180.0, 1e-12);
  EXPECT_EQ(scenario.frame_times.dropped, (std::vector<int>{3, 9}));
  ASSERT_TRUE(scenario.told_site);
  EXPECT_FALSE(scenario.told_site->camera);
  const VehicleScene& a = scenario.vehicles.at(0);
  ASSERT_TRUE(a.beam);
  // Left-hand traffic, aimed down by half a degree, dimmed to 0.8.
  EXPECT_NEAR(a.beam->intensity_cd(0.02, -0.03),
              0.8 * LowBeam{TrafficSide::left}.intensity_cd(0.02, -0.03 + 0.5 * kPi / 180.0),
              1e-3 * a.beam->intensity_cd(0.02, -0.03));
  EXPECT_EQ(a.waveform.frequency_hz(), 200.0);
  EXPECT_EQ(a.speed_changes.at(0).acceleration_mps2, -2.0);
  EXPECT_EQ(a.lane_changes.at(0).to_lane, 1);
  EXPECT_NEAR(a.lane_changes.at(0).shift_m, -3.5, 1e-12);
  EXPECT_NEAR(a.pitch.phase_rad, 0.5 * kPi, 1e-12);
  EXPECT_NEAR(scenario.vehicles.at(1).beam->intensity_cd(0.0, 0.0), 500.0, 1e-9);
  EXPECT_NEAR(scenario.vehicles.at(2).beam->intensity_cd(40.0 * kPi / 180.0, 0.0), 450.0, 1e-9);
  EXPECT_EQ(scenario.street_lamps.at(0).waveform.frequency_hz(), 100.0);
  EXPECT_EQ(scenario.signs.at(0).width_m, 2.0);
  EXPECT_EQ(scenario.encoder.quality, 4);
}

TEST_F(LoadScenario, BadWorldsAreNamed) {
  const std::string head = "duration_s: 4\n" + std::string(kSite);
  const std::string car = "  - {id: a, lane: near, speed_mps: 20, range_at_zero_m: 60";
  std::string exposure = head, radius = head, low = head;
  exposure.replace(exposure.find("exposure_s: 0.001"), 17, "exposure_s: -0.01");
  radius.replace(radius.find("kind: straight"), 14,
                 "kind: curved\n    radius_m: 0\n    turn: left");
  low.replace(low.find("[0.0, 0.0, 5.0]"), 15, "[0.0, -3.4, 1.2]");
  const struct {
    std::string text, part;
  } cases[] = {
      {exposure, "exposure_s"},
      {radius, "radius_m"},
      {low + "vehicles:\n" + car + "}\n", "the camera is inside this vehicle"},
      {head + "vehicles:\n" + car + ", beam: low_bem}\n", "low_bem"},
      {head + "vehicles:\n" + car + ", beam: high_beam, intensity_cd: 5}\n", "beam_scale"},
      {head + "vehicles:\n" + car + ", beam: lambertian}\n", "half_power_angle_deg"},
      {head + "vehicles:\n" + car + ", lane_changes: [{from_s: 1, to: fat}]}\n", "fat"},
      {head + "vehicles:\n" + car + ", pulses: {frequency_hz: 100, duty: 0}}\n", "duty"},
      {head + "vehicles:\n" + car +
           ", speed_changes: [{from_s: 2, acceleration_mps2: 1}, {from_s: 1, acceleration_mps2: "
           "1}]}\n",
       "in order"},
      {head + "weather: {visibility_m: 100, rain_mm_per_h: 3}\n", "more than once"},
      {head + "weather: {visibility_m: 0}\n", "visibility_m"},
      {head + "encoder: {codec: mjpeg, crf: 3}\n", "quality"},
      {head + "photodiode: {adc_bits: 12}\n", "full_scale_w"},
      {head + "photodiode: {quantity: counts}\n", "adc_bits"},
      {head + "photodiode: {gaps: [{from_s: 2, to_s: 1}]}\n", "from_s"},
      {head + "signs: [{position_m: [1, 2, 3], width_m: 0, height_m: 1}]\n", "width_m"},
      {head + "frame_times: {dropped_share: 1.5}\n", "dropped_share"},
      {head + "  photodiode: {position_m: [0, 0, 5]}\n  channel: {gain_db: -42, "
              "path_loss_exponent: 2}\nphotodiode: {shot_noise: true}\n",
       "responsivity_a_per_w"},
  };
  for (const auto& [text, part] : cases) {
    const std::string found = problems(text);
    EXPECT_NE(found.find(part), std::string::npos) << text << "gave: " << found;
    EXPECT_NE(found.find("s.yaml"), std::string::npos);
  }
}

// File, line, full key, fault and remedy, and nothing else.
TEST_F(LoadScenario, OneFaultOneMessage) {
  std::string text = "duration_s: 4\n" + std::string(kSite);
  text.replace(text.find("exposure_s: 0.001"), 17, "exposure_s: -0.01");
  const std::string found = problems(text);
  EXPECT_NE(found.find("site.camera.exposure_s: -0.01 is out of range; must be > 0"),
            std::string::npos)
      << found;
  EXPECT_EQ(found.find("missing"), std::string::npos) << found;
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
