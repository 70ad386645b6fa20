#include <algorithm>
#include <filesystem>

#include <gtest/gtest.h>

#include "pipelines/run_pipeline.h"
#include "support/temporary_folder.h"
#include "synth/render.h"
#include "synth/scenario.h"

namespace vildar {
namespace {

namespace fs = std::filesystem;

// One car whose lamps clip, at half size and for two seconds.
RunOutcome run_rendered(const fs::path& folder, ClipCodec codec) {
  Scenario scenario =
      load_scenario(fs::path(VILDAR_SOURCE_DIR) / "tests/bench/four_vehicles_1080p.yaml");
  scenario.vehicles.resize(1);
  scenario.duration_s = 2.0;
  CameraSite& camera = *scenario.site.camera;
  camera.width_px /= 2;
  camera.height_px /= 2;
  for (double& focal_px : camera.focal_px) focal_px *= 0.5;
  for (double& middle_px : camera.principal_px) middle_px = (middle_px + 0.5) * 0.5 - 0.5;
  scenario.encoder = {};
  scenario.encoder.codec = codec;
  render(scenario, folder, {});
  RunOptions options;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().stem() == "clip") options.clip = entry.path();
  options.site = folder / "site.yaml";
  options.out = folder / "out";
  return run_pipeline(options);
}

bool lossy_light_is_told(const RunOutcome& outcome) {
  return std::ranges::any_of(outcome.summary.warnings, [](const std::string& warning) {
    return warning.find("no speed is taken from how it changes") != std::string::npos;
  });
}

MethodResult camera_slope(const RunOutcome& outcome) {
  const auto& methods = outcome.vehicles.at(0).methods;
  const auto slope = std::ranges::find(methods, Method::power_slope_camera, &MethodResult::method);
  return slope != methods.end() ? *slope : MethodResult{};
}

TEST(CameraPsf, GivesTheLightOfLampsThatClipInALosslessClip) {
  const TemporaryFolder folder;
  const RunOutcome outcome = run_rendered(folder.path(), ClipCodec::ffv1);
  EXPECT_FALSE(lossy_light_is_told(outcome));
  ASSERT_EQ(outcome.vehicles.size(), 1U);
  const MethodResult slope = camera_slope(outcome);
  const auto* speed = std::get_if<SpeedEstimate>(&slope.speed);
  ASSERT_NE(speed, nullptr) << "saturated, where lamps are not fitted";
  EXPECT_NEAR(speed->speed_mps, 15.0, 1.0);
}

TEST(CameraPsf, GivesNoSpeedFromClippedLightOfALossyClipAndSaysSo) {
  const TemporaryFolder folder;
  const RunOutcome outcome = run_rendered(folder.path(), ClipCodec::mjpeg);
  EXPECT_TRUE(lossy_light_is_told(outcome));
  ASSERT_EQ(outcome.vehicles.size(), 1U);
  EXPECT_EQ(std::get<Miss>(camera_slope(outcome).speed), Miss::saturated);
}

}  // namespace
}  // namespace vildar
