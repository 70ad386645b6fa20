#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <variant>
#include <vector>

#include "core/random.h"
#include "pipelines/run_pipeline.h"
#include "support/temporary_folder.h"
#include "synth/clip_writer.h"
#include "synth/renderer.h"

namespace vildar {
namespace {

const std::filesystem::path kSample =
    std::filesystem::path(VILDAR_SOURCE_DIR) / "data_samples" / "straight";

// To measure the sample's scene as it is rendered anew.
RunOptions options_in(const std::filesystem::path& folder) {
  RunOptions options;
  options.clip = folder / "clip.mp4";
  options.site = kSample / "site.yaml";
  options.out = folder / "out";
  return options;
}

bool warned_of_lost_frames(const RunOutcome& run) {
  return std::ranges::any_of(run.summary.warnings, [](const std::string& warning) {
    return warning.find("frames are missing") != std::string::npos;
  });
}

// The sample's scene, and the clip's stamps even whatever share of the frames is lost.
RunOutcome run_that_lost(double share) {
  const TemporaryFolder folder;
  const Scenario scenario = load_scenario(kSample / "scenario.yaml");
  const RunOptions options = options_in(folder.path());
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
  const RunOptions options = options_in(folder.path());
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

// The sample's scene taken at one rate and given another, as editors and video sites do: frames
// stand up to half a frame early and late by turns.
TEST(AnotherRate, ItsFramesAreMeasuredAtTheTimesAtWhichTheyWereTaken) {
  for (const auto& [taken_hz, clip_hz] : {std::pair(25.0, 30.0), std::pair(30.0, 25.0)}) {
    const TemporaryFolder folder;
    Scenario scenario = load_scenario(kSample / "scenario.yaml");
    const RunOptions options = options_in(folder.path());
    scenario.frame_rate_hz = clip_hz;
    Renderer renderer(scenario);
    ClipWriter writer(*options.clip, scenario);
    const int frames = static_cast<int>(scenario.duration_s * clip_hz);
    for (int i = 0; i < frames; ++i)
      writer.write(renderer.image(std::floor(i * taken_hz / clip_hz) / taken_hz));
    writer.commit();
    const RunOutcome run = run_pipeline(options);
    EXPECT_GT(run.summary.counts.at("frames_retimed"), frames * 4 / 5) << clip_hz;
    EXPECT_TRUE(std::ranges::any_of(run.summary.warnings, [&](const std::string& warning) {
      return warning.find(taken_hz == 25.0 ? "even times of 25.00" : "even times of 30.00") !=
             std::string::npos;
    })) << clip_hz;
    ASSERT_EQ(run.vehicles.size(), scenario.vehicles.size()) << clip_hz;
    for (const VehicleResult& vehicle : run.vehicles) {
      ASSERT_FALSE(vehicle.withheld) << vehicle.track_id;
      EXPECT_TRUE(std::ranges::any_of(scenario.vehicles, [&](const VehicleScene& truth) {
        return std::abs(vehicle.speed.speed_mps - truth.speed_mps) < 2.0 * vehicle.speed.std_mps;
      })) << vehicle.speed.speed_mps;
    }
  }
}

/// Even rows of one picture between the odd ones of another.
Frame woven(const Frame& even, const Frame& odd) {
  const auto stride = static_cast<std::size_t>(even.luma.stride_bytes);
  auto rows =
      std::make_shared<std::vector<std::uint8_t>>(stride * std::size_t(even.luma.height_px));
  for (int v = 0; v < even.luma.height_px; ++v)
    std::memcpy(rows->data() + std::size_t(v) * stride, (v % 2 == 0 ? even : odd).luma.row(v),
                std::size_t(even.luma.width_px));
  Frame frame = even;
  frame.luma.data = rows->data();
  frame.luma.row_maxima = nullptr;
  frame.luma.owner = rows;
  return frame;
}

bool warned_of_fields(const RunOutcome& run) {
  return std::ranges::any_of(run.summary.warnings, [](const std::string& warning) {
    return warning.find("is interlaced without a word of it") != std::string::npos;
  });
}

// The sample's scene by a camera that takes the odd rows half a frame after the even ones, in a
// clip that says nothing of it.
TEST(WovenClip, IsReadByOneField) {
  const TemporaryFolder folder;
  const Scenario scenario = load_scenario(kSample / "scenario.yaml");
  RunOptions options = options_in(folder.path());
  Renderer renderer(scenario);
  ClipWriter writer(*options.clip, scenario);
  const double period_s = 1.0 / scenario.frame_rate_hz;
  for (int i = 0; i * period_s < scenario.duration_s; ++i) {
    const Frame even = renderer.image(i * period_s);
    writer.write(woven(even, renderer.image((i + 0.5) * period_s)));
  }
  writer.commit();
  const RunOutcome run = run_pipeline(options);
  EXPECT_TRUE(warned_of_fields(run));
  ASSERT_EQ(run.vehicles.size(), scenario.vehicles.size());
  for (const VehicleScene& truth : scenario.vehicles)
    EXPECT_TRUE(std::ranges::any_of(run.vehicles, [&](const VehicleResult& vehicle) {
      return !vehicle.withheld &&
             std::abs(vehicle.speed.speed_mps - truth.speed_mps) < 2.0 * vehicle.speed.std_mps;
    })) << truth.speed_mps;
  options.clip = kSample / "clip.mp4";
  EXPECT_FALSE(warned_of_fields(run_pipeline(options))) << "of whole pictures";
}

}  // namespace
}  // namespace vildar
