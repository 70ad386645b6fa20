#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "scenes.h"
#include "synth/truth.h"

namespace vildar {
namespace {

std::string content(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

class Sample : public ::testing::TestWithParam<const char*> {};

// The clip is left out: its bytes depend on the version of the codec library.
TEST_P(Sample, IsWhatItsScenarioGives) {
  const std::filesystem::path folder =
      std::filesystem::path(VILDAR_SOURCE_DIR) / "data_samples" / GetParam();
  const Scenario scenario = load_scenario(folder / "scenario.yaml");
  const auto truth = truth_tracks(scenario);
  EXPECT_TRUE(truth_tracks_csv(scenario, truth) == content(folder / "truth_tracks.csv"));
  EXPECT_TRUE(truth_vehicles_csv(scenario, truth) == content(folder / "truth_vehicles.csv"));
  if (!scenario.site.photodiodes.empty()) {
    EXPECT_TRUE(trace_text(scenario) == content(folder / "photodiode.csv"));
  }
  std::uintmax_t bytes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) bytes += entry.file_size();
  EXPECT_LT(bytes, 1'000'000u);
}

INSTANTIATE_TEST_SUITE_P(DataSamples, Sample,
                         ::testing::Values("straight", "three_lanes", "curve", "dashcam",
                                           "photodiode_only", "wet_night"),
                         [](const auto& sample) { return std::string(sample.param); });

}  // namespace
}  // namespace vildar
