#include "capture/photodiode_csv.h"

#include <cmath>
#include <cstdio>

#include "core/error.h"
#include "core/random.h"
#include "support/file_bytes.h"
#include "support/temporary_folder.h"

namespace vildar {
namespace {

class PhotodiodeCsv : public ::testing::Test {
 protected:
  PhotodiodeRecording read(const std::string& text) {
    test::write_bytes(folder_.path() / "trace.csv", text);
    return read_photodiode_csv(folder_.path() / "trace.csv");
  }
  std::string error_of(const std::string& text) {
    try {
      read(text);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }
  TemporaryFolder folder_;
};

TEST_F(PhotodiodeCsv, ColumnsInAnyOrderCommentsBomAndCrlf) {
  const PhotodiodeRecording trace = read(
      "\xef\xbb\xbf# logger 3\r\n\r\npd1_current_a, t_s "
      ",temperature,pd0_current_a\r\n1e-6,0.5,20,2e-6\r\n"
      "# half way\r\n-3e-6,0.6,,4e-6\r\n");
  EXPECT_EQ(trace.quantity, PowerQuantity::current_a);
  EXPECT_EQ(trace.ids, (std::vector<std::string>{"pd1", "pd0"}));
  EXPECT_EQ(trace.time_s, (std::vector<double>{0.5, 0.6}));
  EXPECT_EQ(trace.values[0], (std::vector<float>{1e-6F, -3e-6F}));
  EXPECT_EQ(trace.values[1], (std::vector<float>{2e-6F, 4e-6F}));
  EXPECT_EQ(trace.rows_read, 2);
  EXPECT_FALSE(trace.damaged);
  ASSERT_EQ(trace.warnings.size(), 1U);
  EXPECT_NE(trace.warnings[0].find("temperature"), std::string::npos);
}

TEST_F(PhotodiodeCsv, EmptyAndNonFiniteCellsAreKeptAsNan) {
  const PhotodiodeRecording trace =
      read("t_s,a_counts,b_counts\n0,,1\n1,nan,2\n2,-inf,3\n3,4,NaN\n");
  ASSERT_EQ(trace.rows_read, 4);
  EXPECT_FALSE(trace.damaged);
  for (int k = 0; k < 3; ++k) EXPECT_TRUE(std::isnan(trace.values[0][static_cast<std::size_t>(k)]));
  EXPECT_EQ(trace.values[0][3], 4.0F);
  EXPECT_EQ(trace.values[1][2], 3.0F);
  EXPECT_TRUE(std::isnan(trace.values[1][3]));
}

TEST_F(PhotodiodeCsv, UnreadableRowsAreCountedByReasonWithTheirFirstLine) {
  const PhotodiodeRecording trace =
      read("t_s,power_w\n0,1\n0.1,1,7\n0.2\n,3\nx,3\n0.3,watt\n0.4,2\n#end\n0.5,1\n");
  EXPECT_EQ(trace.time_s, (std::vector<double>{0.0, 0.4, 0.5}));
  EXPECT_TRUE(trace.damaged);
  EXPECT_EQ(trace.rejected,
            (std::map<std::string, std::int64_t>{
                {"wrong_cell_count", 2}, {"unreadable_time", 2}, {"unreadable_value", 1}}));
  ASSERT_EQ(trace.warnings.size(), 3U);
  EXPECT_NE(trace.warnings[0].find("trace.csv:5:"), std::string::npos) << trace.warnings[0];
  EXPECT_NE(trace.warnings[1].find("trace.csv:7:"), std::string::npos) << trace.warnings[1];
  EXPECT_NE(trace.warnings[2].find("trace.csv:3:"), std::string::npos) << trace.warnings[2];
}

TEST_F(PhotodiodeCsv, TimesThatNoClockGivesAreUnreadable) {
  const PhotodiodeRecording trace = read("t_s,power_w\n0,1\n0.981e308,2\n-1e11,3\n1.8e9,4\n");
  EXPECT_EQ(trace.time_s, (std::vector<double>{0.0, 1.8e9}));
  EXPECT_EQ(trace.rejected.at("unreadable_time"), 2);
}

TEST_F(PhotodiodeCsv, ALastRowCutOffInTheMiddleIsNotBelieved) {
  const PhotodiodeRecording cut = read("t_s,power_w\n0.0,1.25e-07\n0.1,1.25e-0");
  EXPECT_EQ(cut.rows_read, 1);
  EXPECT_EQ(cut.rejected.at("cut_off_last_row"), 1);
  EXPECT_TRUE(cut.damaged);
  for (const char* text :
       {"t_s,power_w\n0.0,1.25e-07\n0.1,1.25e-07", "t_s,power_w\r\n0.0,1.25e-07\r\n0.1,1.25e-07"}) {
    const PhotodiodeRecording whole = read(text);
    EXPECT_EQ(whole.rows_read, 2);
    EXPECT_FALSE(whole.damaged);
  }
}

TEST_F(PhotodiodeCsv, HeadersThatCannotBeUsedShowTheOneExpected) {
  for (const char* text :
       {"0.0,1.0\n0.1,2.0\n", "time,power\n0,1\n", "t_s,temperature\n0,1\n", "power_w\n1\n",
        "t_s,a_power_w,b_current_a\n0,1,2\n", "t_s,power_w,power_w\n0,1,2\n",
        "t_s,t_s,power_w\n0,1,2\n", "t_s,power_w,pd1_power_w\n0,1,2\n", "t_s;power_w\n0;1\n"}) {
    const std::string error = error_of(text);
    EXPECT_NE(error.find("trace.csv:1:"), std::string::npos) << error;
    EXPECT_NE(error.find("t_s,power_w"), std::string::npos) << error;
  }
}

TEST_F(PhotodiodeCsv, FilesWithoutRowsOrTextAreRefused) {
  EXPECT_NE(error_of("").find("empty"), std::string::npos);
  EXPECT_NE(error_of("# only this\n").find("no header"), std::string::npos);
  EXPECT_NE(error_of("t_s,power_w\n").find("no row"), std::string::npos);
  EXPECT_NE(error_of("t_s,power_w\nx,1\n").find("unreadable_time from line 2"), std::string::npos);
  EXPECT_NE(error_of(std::string("\x89PNG\0\0\n\0", 8)).find("binary"), std::string::npos);
  EXPECT_NE(error_of("\xff\xfet\0_\0s\0").find("UTF-16"), std::string::npos);
  EXPECT_THROW(read_photodiode_csv(folder_.path() / "missing.csv"), InputError);
  std::filesystem::create_directory(folder_.path() / "folder.csv");
  EXPECT_THROW(read_photodiode_csv(folder_.path() / "folder.csv"), InputError);
}

TEST_F(PhotodiodeCsv, LongFilesCrossReadBlocksUnharmed) {
  constexpr int kRows = 120'000;  // about 3 MB, three blocks
  Random random(5);
  std::string text = "t_s,power_w\n";
  std::vector<double> times_s;
  std::vector<float> powers_w;
  for (int k = 0; k < kRows; ++k) {
    char row[64];
    std::snprintf(row, sizeof row, "%.5f,%.*e\n", k * 1e-4,
                  static_cast<int>(random.uniform(0.0, 12.0)), random.normal());
    text += row;
    double time_s = 0.0, power_w = 0.0;
    ASSERT_EQ(std::sscanf(row, "%lf,%lf", &time_s, &power_w), 2);
    times_s.push_back(time_s);
    powers_w.push_back(static_cast<float>(power_w));
  }
  const PhotodiodeRecording trace = read(text);
  EXPECT_EQ(trace.time_s, times_s);
  EXPECT_EQ(trace.values[0], powers_w);
}

}  // namespace
}  // namespace vildar
