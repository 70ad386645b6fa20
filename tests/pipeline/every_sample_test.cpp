#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "config/site_file.h"
#include "evaluate/folders.h"
#include "evaluate/requirement.h"
#include "pipelines/run_pipeline.h"

namespace vildar {
namespace {

namespace fs = std::filesystem;

// The lines `  - METRIC>=NUMBER` below `expected:` of a manifest.
std::vector<Requirement> expected_of(const fs::path& manifest) {
  std::ifstream stream(manifest);
  std::vector<Requirement> requirements;
  bool inside = false;
  for (std::string line; std::getline(stream, line);) {
    if (line.rfind("  - ", 0) == 0 && inside)
      requirements.push_back(parse_requirement(line.substr(4)));
    else
      inside = line == "expected:";
  }
  return requirements;
}

class EverySample : public ::testing::TestWithParam<const char*> {};

TEST_P(EverySample, ScoresAsItsManifestSays) {
  const fs::path sample = fs::path(VILDAR_SOURCE_DIR) / "data_samples" / GetParam();
  const std::vector<Requirement> requirements = expected_of(sample / "manifest.yaml");
  ASSERT_FALSE(requirements.empty());
  RunOptions options;
  if (fs::exists(sample / "clip.mp4")) options.clip = sample / "clip.mp4";
  if (fs::exists(sample / "photodiode.csv")) options.photodiode = sample / "photodiode.csv";
  options.site = sample / "site.yaml";
  options.out = fs::path(::testing::TempDir()) /
                ("vildar_" + std::string(GetParam()) + "_" + std::to_string(::getpid()));
  run_pipeline(options);
  const Evaluation evaluation =
      evaluate(read_truth_folder(sample), read_run_folder(options.out), {});
  for (const RequirementResult& result : check(requirements, evaluation))
    EXPECT_TRUE(result.holds) << to_string(result);
  fs::remove_all(options.out);
}

INSTANTIATE_TEST_SUITE_P(DataSamples, EverySample,
                         ::testing::Values("straight", "three_lanes", "curve", "dashcam",
                                           "photodiode_only", "wet_night"),
                         [](const auto& sample) { return std::string(sample.param); });

}  // namespace
}  // namespace vildar
