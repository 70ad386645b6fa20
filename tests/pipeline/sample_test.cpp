#include <cmath>
#include <fstream>
#include <map>
#include <sstream>

#include <gtest/gtest.h>

#include "pipelines/run_pipeline.h"

namespace vildar {
namespace {

namespace fs = std::filesystem;

const fs::path kStraightSample = fs::path(VILDAR_SOURCE_DIR) / "data_samples/straight";

using Row = std::map<std::string, std::string>;

std::vector<Row> table(const fs::path& file) {
  std::ifstream stream(file);
  const auto cells = [](const std::string& line) {
    std::vector<std::string> found;
    std::istringstream rest(line);
    for (std::string cell; std::getline(rest, cell, ',');) found.push_back(cell);
    return found;
  };
  std::string line;
  std::getline(stream, line);
  const std::vector<std::string> names = cells(line);
  std::vector<Row> rows;
  while (std::getline(stream, line)) {
    const std::vector<std::string> values = cells(line);
    Row row;
    for (std::size_t i = 0; i < values.size(); ++i) row[names[i]] = values[i];
    rows.push_back(row);
  }
  return rows;
}

// Truth comes from the renderer's own files, not from any earlier run.
class Sample : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    out_ = fs::path(testing::TempDir()) / ("vildar_sample_" + std::to_string(::getpid()));
    RunOptions options;
    options.clip = kStraightSample / "clip.mp4";
    options.photodiode = kStraightSample / "photodiode.csv";
    options.site = kStraightSample / "site.yaml";
    options.out = out_;
    options.annotate = true;
    options.blobs = true;
    outcome_ = run_pipeline(options);
  }
  static void TearDownTestSuite() { fs::remove_all(out_); }

  static fs::path out_;
  static RunOutcome outcome_;
};
fs::path Sample::out_;
RunOutcome Sample::outcome_;

TEST_F(Sample, EveryVehicleIsFoundAndEachSpeedHolds) {
  constexpr double kMostRelativeError = 0.03;
  constexpr double kMostSigmas = 3.0;
  const std::vector<Row> truth = table(kStraightSample / "truth_vehicles.csv");
  ASSERT_GE(truth.size(), 4U);
  ASSERT_EQ(outcome_.vehicles.size(), truth.size());
  std::vector<bool> taken(outcome_.vehicles.size(), false);
  for (const Row& row : truth) {
    const double true_mps = std::stod(row.at("speed_mps"));
    std::size_t best = taken.size();
    for (std::size_t i = 0; i < taken.size(); ++i) {
      const VehicleResult& vehicle = outcome_.vehicles[i];
      if (taken[i] || vehicle.lane != row.at("lane")) continue;
      const double miss_s = std::abs(vehicle.speed.time_s - std::stod(row.at("t_ref_s")));
      if (best == taken.size() ||
          miss_s < std::abs(outcome_.vehicles[best].speed.time_s - std::stod(row.at("t_ref_s"))))
        best = i;
    }
    ASSERT_NE(best, taken.size()) << "vehicle " << row.at("vehicle_id") << " was not found";
    taken[best] = true;
    const VehicleResult& vehicle = outcome_.vehicles[best];
    ASSERT_FALSE(vehicle.withheld) << name_of(*vehicle.withheld);
    EXPECT_EQ(name_of(vehicle.direction), row.at("direction"));
    const double error_mps = vehicle.speed.speed_mps - true_mps;
    EXPECT_LE(std::abs(error_mps), kMostRelativeError * true_mps) << row.at("vehicle_id");
    EXPECT_LE(std::abs(error_mps), kMostSigmas * vehicle.speed.std_mps) << row.at("vehicle_id");
  }
}

TEST_F(Sample, WritesEveryFileOfTheContract) {
  for (const char* name : {"speeds.csv", "methods.csv", "tracks.csv", "blobs.csv", "run.json",
                           "report.html", "annotated.mp4"})
    EXPECT_GT(fs::file_size(out_ / name), 100U) << name;
  for (const auto& entry : fs::directory_iterator(out_))
    EXPECT_EQ(entry.path().string().find(".part"), std::string::npos) << entry.path();
}

TEST_F(Sample, TheAnnotatedVideoHasEveryFrame) {
  ClipSource annotated(out_ / "annotated.mp4");
  ClipSource original(kStraightSample / "clip.mp4");
  std::int64_t frames = 0, expected = 0;
  while (annotated.next()) ++frames;
  while (original.next()) ++expected;
  EXPECT_EQ(frames, expected);
}

TEST_F(Sample, IsUnderOneMegabyte) {
  std::uintmax_t bytes = 0;
  for (const auto& entry : fs::directory_iterator(kStraightSample))
    bytes += fs::file_size(entry.path());
  EXPECT_LT(bytes, 1'000'000U);
}

}  // namespace
}  // namespace vildar
