#include <gtest/gtest.h>

#include <fstream>

#include <CLI/CLI.hpp>

#include "core/error.h"
#include "pipelines/commands.h"
#include "support/file_bytes.h"
#include "support/temporary_folder.h"

namespace vildar {
namespace {

class EvaluateCommand : public testing::Test {
 protected:
  void SetUp() override {
    // One vehicle at 20 m/s (72 km/h), measured at 20.5.
    folder_.write("truth_vehicles.csv",
                  "vehicle_id,t_ref_s,speed_mps,acceleration_mps2\nA,0.5,20,0\n");
    folder_.write("truth_tracks.csv",
                  "frame,t_s,vehicle_id,u_left_px,v_left_px,u_right_px,v_right_px,x_m,y_m,range_m\n"
                  "0,0.0,A,100,50,140,50,50,-4,50\n"
                  "1,0.1,A,100,50,140,50,48,-4,48\n");
    folder_.write("speeds.csv",
                  "track_id,direction,status,t_first_s,t_last_s,t_ref_s,speed_mps\n"
                  "1,oncoming,measured,0,0.1,0.05,20.5\n");
    folder_.write("tracks.csv",
                  "frame,t_s,track_id,u_left_px,v_left_px,u_right_px,v_right_px,azimuth_rad\n"
                  "0,0.0,1,100,50,140,50,-0.0798\n");
  }

  int run(const std::vector<std::string>& options) {
    std::vector<std::string> words{folder_.path().string(), folder_.path().string()};
    words.insert(words.end(), options.begin(), options.end());
    words.insert(words.begin(), "evaluate");
    std::ranges::reverse(words);  // the order CLI11 takes them in
    CLI::App program;
    int exit_code = -1;
    add_evaluate(program, exit_code);
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    try {
      program.parse(words);
    } catch (const std::exception&) {
      stdout_ = testing::internal::GetCapturedStdout();
      stderr_ = testing::internal::GetCapturedStderr();
      throw;
    }
    stdout_ = testing::internal::GetCapturedStdout();
    stderr_ = testing::internal::GetCapturedStderr();
    return exit_code;
  }

  TemporaryFolder folder_;
  std::string stdout_, stderr_;
};

TEST_F(EvaluateCommand, PrintsTablesOrJsonAndWritesTheJson) {
  EXPECT_EQ(run({}), 0);
  EXPECT_NE(stdout_.find("+1.80"), std::string::npos) << stdout_;
  EXPECT_TRUE(stderr_.empty());
  const auto file = folder_.path() / "scores" / "a.json";
  EXPECT_EQ(run({"--json", "--out", file.string()}), 0);
  EXPECT_EQ(stdout_, test::bytes_of(file));
  EXPECT_EQ(stdout_.front(), '{');
}

// What it wrote itself it may write again.
TEST_F(EvaluateCommand, DoesNotWriteOverWhatItReads) {
  const std::string speeds = test::bytes_of(folder_.path() / "speeds.csv");
  for (const char* name : {"speeds.csv", "truth_vehicles.csv", "run.json"}) {
    if (!std::filesystem::exists(folder_.path() / name)) folder_.write(name, "{}");
    EXPECT_THROW(run({"--out", (folder_.path() / name).string()}), ConfigError) << name;
  }
  EXPECT_EQ(test::bytes_of(folder_.path() / "speeds.csv"), speeds);
  const std::string scores = (folder_.path() / "scores.json").string();
  EXPECT_EQ(run({"--out", scores}), 0);
  EXPECT_EQ(run({"--out", scores}), 0);
}

TEST_F(EvaluateCommand, ABrokenRequirementExitsSixAndNamesIt) {
  EXPECT_EQ(run({"--require", "recall>=0.95", "--require", "max_error_kmh<=3"}), 0);
  EXPECT_EQ(run({"--require", "recall>=0.95", "max_error_kmh<=1.5"}), 6);
  EXPECT_EQ(stderr_.rfind("vildar: max_error_kmh<=1.5: does not hold, it is 1.8", 0), 0U)
      << stderr_;
  EXPECT_EQ(stderr_.find("recall"), std::string::npos);
}

TEST_F(EvaluateCommand, BearingsAreTakenFromWhereTheSiteHasTheCamera) {
  ASSERT_EQ(run({"--require", "azimuth_rms_rad<=0.001"}), 0) << stderr_;
  folder_.write("site.yaml",
                "version: 1\n"
                "camera:\n"
                "  image_size_px: [1920, 1080]\n"
                "  focal_px: [1400, 1400]\n"
                "  principal_px: [959.5, 539.5]\n"
                "  position_m: [0, 2, 5]\n"
                "  yaw_deg: 0\n"
                "  pitch_deg: 0\n"
                "  roll_deg: 0\n");
  EXPECT_EQ(run({"--require", "azimuth_rms_rad<=0.001"}), 6);
}

TEST_F(EvaluateCommand, WrongNamesAndMissingFilesAreErrorsOfTheirKind) {
  EXPECT_THROW(run({"--require", "recal>=0.95"}), ConfigError);
  std::filesystem::remove(folder_.path() / "speeds.csv");
  EXPECT_THROW(run({}), InputError);
}

}  // namespace
}  // namespace vildar
