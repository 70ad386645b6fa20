#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "synth/photodiode_trace.h"
#include "synth/truth.h"

namespace vildar {
namespace {

std::string content(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

// The clip is left out: its bytes depend on the version of the codec library.
TEST(StraightSample, IsWhatItsScenarioGives) {
  const std::filesystem::path folder =
      std::filesystem::path(VILDAR_SOURCE_DIR) / "data_samples" / "straight";
  const Scenario scenario = load_scenario(folder / "scenario.yaml");
  const auto truth = truth_tracks(scenario);
  EXPECT_TRUE(truth_tracks_csv(scenario, truth) == content(folder / "truth_tracks.csv"));
  EXPECT_TRUE(truth_vehicles_csv(scenario, truth) == content(folder / "truth_vehicles.csv"));
  EXPECT_TRUE(trace_csv(scenario, render_trace(scenario)) == content(folder / "photodiode.csv"));
}

}  // namespace
}  // namespace vildar
