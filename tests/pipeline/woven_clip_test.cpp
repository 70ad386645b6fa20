#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <vector>

#include "pipelines/run_pipeline.h"
#include "support/temporary_folder.h"
#include "synth/clip_writer.h"
#include "synth/renderer.h"

namespace vildar {
namespace {

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
  const auto sample = std::filesystem::path(VILDAR_SOURCE_DIR) / "data_samples" / "straight";
  const Scenario scenario = load_scenario(sample / "scenario.yaml");
  RunOptions options;
  options.clip = folder.path() / "clip.mp4";
  options.site = sample / "site.yaml";
  options.out = folder.path() / "out";
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
  options.clip = sample / "clip.mp4";
  EXPECT_FALSE(warned_of_fields(run_pipeline(options))) << "of whole pictures";
}

}  // namespace
}  // namespace vildar
