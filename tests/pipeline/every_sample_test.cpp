#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

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

// How far below its expected scores a run may fall: codec libraries and compilers round otherwise.
// A better run passes.
struct Tolerance {
  const char* metric;
  double worse;  ///< by at most this
  bool high_is_good;
};
constexpr Tolerance kTolerances[] = {
    {"recall", 0.0, true},         {"matched", 0.0, true},
    {"precision", 0.0, true},      {"missed", 0.0, false},
    {"false", 0.0, false},         {"mean_abs_error_kmh", 0.3, false},
    {"max_error_kmh", 0.5, false}, {"share_within_limits", 0.0, true},
    {"hota", 0.02, true},          {"idf1", 0.02, true},
    {"id_switches", 0.0, false},   {"azimuth_rms_rad", 1e-4, false},
};

// expected_scores.json is what `vildar evaluate --json` said when it was last looked at.
void expect_scores(const fs::path& file, const Evaluation& evaluation) {
  ASSERT_TRUE(fs::exists(file)) << "make it with tools/render_samples.py PROGRAM --scores";
  const nlohmann::json expected = nlohmann::json::parse(std::ifstream(file)).at("metrics");
  const std::vector<NamedMetric> metrics = named_metrics(evaluation);
  for (const Tolerance& tolerance : kTolerances) {
    const auto found = std::find_if(metrics.begin(), metrics.end(), [&](const NamedMetric& metric) {
      return metric.name == tolerance.metric;
    });
    const auto entry = expected.find(tolerance.metric);
    if (entry == expected.end() || entry->is_null()) continue;  // no pixels: no tracking scores
    ASSERT_TRUE(found != metrics.end() && found->value) << tolerance.metric;
    const double better =
        (tolerance.high_is_good ? 1.0 : -1.0) * (*found->value - entry->get<double>());
    EXPECT_GE(better, -tolerance.worse - 1e-9)
        << tolerance.metric << " is " << *found->value << ", expected " << *entry
        << "; where that is meant: tools/render_samples.py PROGRAM --scores";
  }
}

// As `vildar evaluate` takes it from the site.yaml beside the truth.
EvaluateOptions view_of(const fs::path& sample) {
  EvaluateOptions view;
  const Site site = load_site(sample / "site.yaml");
  if (!site.camera) return view;
  view.camera_xy_m = {site.camera->position_m[0].mean, site.camera->position_m[1].mean};
  view.rolling_shutter_s = site.camera->rolling_shutter_s;
  view.image_height_px = site.camera->height_px;
  return view;
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
      evaluate(read_truth_folder(sample), read_run_folder(options.out), view_of(sample));
  for (const RequirementResult& result : check(requirements, evaluation))
    EXPECT_TRUE(result.holds) << to_string(result);
  expect_scores(sample / "expected_scores.json", evaluation);
  fs::remove_all(options.out);
}

INSTANTIATE_TEST_SUITE_P(DataSamples, EverySample,
                         ::testing::Values("straight", "three_lanes", "curve", "dashcam",
                                           "photodiode_only", "wet_night"),
                         [](const auto& sample) { return std::string(sample.param); });

}  // namespace
}  // namespace vildar
