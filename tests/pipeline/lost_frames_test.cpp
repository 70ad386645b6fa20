#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <variant>

#include "core/random.h"
#include "pipelines/run_pipeline.h"
#include "support/temporary_folder.h"
#include "synth/clip_writer.h"
#include "synth/renderer.h"

namespace vildar {
namespace {

const std::filesystem::path kSample =
    std::filesystem::path(VILDAR_SOURCE_DIR) / "data_samples" / "straight";

bool warned_of_lost_frames(const RunOutcome& run) {
  return std::ranges::any_of(run.summary.warnings, [](const std::string& warning) {
    return warning.find("frames are missing") != std::string::npos;
  });
}

// The sample's scene, and the clip's stamps even whatever share of the frames is lost.
RunOutcome run_that_lost(double share) {
  const TemporaryFolder folder;
  const Scenario scenario = load_scenario(kSample / "scenario.yaml");
  RunOptions options;
  options.clip = folder.path() / "clip.mp4";
  options.site = kSample / "site.yaml";
  options.out = folder.path() / "out";
  Renderer renderer(scenario);
  ClipWriter writer(*options.clip, scenario);
  Random random(5);
  const int frames = static_cast<int>(scenario.duration_s * scenario.frame_rate_hz);
  for (int i = 0; i < frames; ++i)
    if (random.uniform(0.0, 1.0) >= share) writer.write(renderer.image(i / scenario.frame_rate_hz));
  writer.commit();
  return run_pipeline(options);
}

TEST(LostFrames, WithholdTheSpeedsTheyChange) {
  const RunOutcome run = run_that_lost(0.15);
  EXPECT_TRUE(warned_of_lost_frames(run));
  EXPECT_GT(run.summary.counts.at("frames_missing_unstamped"), 15);
  int withheld = 0;
  for (const VehicleResult& vehicle : run.vehicles) {
    EXPECT_TRUE(vehicle.withheld) << vehicle.track_id << ": " << vehicle.speed.speed_mps << " m/s";
    if (vehicle.withheld != Miss::frames_missing) continue;
    ++withheld;
    EXPECT_NE(vehicle.warnings.back().find("frames are missing"), std::string::npos);
    for (const MethodResult& row : vehicle.methods)
      EXPECT_TRUE(std::holds_alternative<Miss>(row.speed)) << name_of(row.method);
  }
  EXPECT_GE(withheld, 2) << "of three that come towards the camera; uneven steps may fit no motion";
}

TEST(LostFrames, AreNotMissedWhereNoneIsLost) {
  const RunOutcome run = run_that_lost(0.0);
  EXPECT_FALSE(warned_of_lost_frames(run));
  EXPECT_EQ(run.summary.counts.at("frames_missing_unstamped"), 0);
  EXPECT_EQ(run.summary.counts.at("frames_repeated"), 0);
  for (const VehicleResult& vehicle : run.vehicles)
    EXPECT_NE(vehicle.withheld, Miss::frames_missing) << vehicle.track_id;
}

// The sample's scene, each picture shown twice in half the time: coding gives the second one
// another noise.
TEST(RepeatedFrames, AreLeftOut) {
  const TemporaryFolder folder;
  Scenario scenario = load_scenario(kSample / "scenario.yaml");
  RunOptions options;
  options.clip = folder.path() / "clip.mp4";
  options.site = kSample / "site.yaml";
  options.out = folder.path() / "out";
  const double rate_hz = scenario.frame_rate_hz;
  scenario.frame_rate_hz = 2.0 * rate_hz;
  Renderer renderer(scenario);
  ClipWriter writer(*options.clip, scenario);
  const int frames = static_cast<int>(scenario.duration_s * rate_hz);
  for (int i = 0; i < 2 * frames; ++i)
    writer.write(renderer.image(static_cast<double>(i / 2) / rate_hz));
  writer.commit();
  const RunOutcome run = run_pipeline(options);
  EXPECT_GT(run.summary.counts.at("frames_repeated"), frames * 4 / 5);
  EXPECT_LE(run.summary.counts.at("frames_repeated"), frames);
  ASSERT_FALSE(run.summary.warnings.empty());
  EXPECT_TRUE(std::ranges::any_of(run.summary.warnings, [](const std::string& warning) {
    return warning.find("show the one before again") != std::string::npos;
  }));
  ASSERT_EQ(run.vehicles.size(), scenario.vehicles.size());
  for (const VehicleResult& vehicle : run.vehicles) {
    EXPECT_FALSE(vehicle.withheld) << vehicle.track_id;
    const auto off_sigmas = [&](const VehicleScene& truth) {
      return std::abs(vehicle.speed.speed_mps - truth.speed_mps) / vehicle.speed.std_mps;
    };
    EXPECT_TRUE(std::ranges::any_of(scenario.vehicles, [&](const VehicleScene& truth) {
      return off_sigmas(truth) < 2.0;
    })) << vehicle.speed.speed_mps;
  }
}

}  // namespace
}  // namespace vildar
