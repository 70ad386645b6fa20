#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <sys/wait.h>

#include <gtest/gtest.h>

namespace vildar {
namespace {

namespace fs = std::filesystem;

const fs::path kSample = fs::path(VILDAR_SOURCE_DIR) / "data_samples/straight";

struct Ran {
  int code = -1;
  std::string out, err;
};

std::string content(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

class Cli : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) /
              ("vildar_cli_" + std::to_string(::getpid()) + "_" +
               testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  Ran run(const std::string& arguments) const {
    const fs::path out = folder_ / "stdout", err = folder_ / "stderr";
    const int status = std::system((std::string(VILDAR_PROGRAM) + " " + arguments + " >" + out.string() +
                                    " 2>" + err.string() + " </dev/null")
                                       .c_str());
    return {WEXITSTATUS(status), content(out), content(err)};
  }
  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  std::string out() const { return " --out " + (folder_ / "out").string(); }
  std::string site() const { return " --site " + (kSample / "site.yaml").string(); }
  std::string clip() const { return " " + (kSample / "clip.mp4").string(); }

  fs::path folder_;
};

TEST_F(Cli, HelpAndVersionSucceed) {
  const Ran version = run("--version");
  EXPECT_EQ(version.code, 0);
  EXPECT_EQ(version.out.rfind("vildar ", 0), 0U);
  for (const char* command : {"run", "render"}) {
    const Ran help = run(std::string(command) + " --help");
    EXPECT_EQ(help.code, 0) << command;
    EXPECT_NE(help.out.find("vildar " + std::string(command)), std::string::npos) << "an example";
  }
}

TEST_F(Cli, WrongUsageIsTwo) {
  EXPECT_EQ(run("").code, 2);
  EXPECT_EQ(run("run").code, 2);
  EXPECT_EQ(run("run --nonsense").code, 2);
  const Ran nothing = run("run" + site() + out());
  EXPECT_EQ(nothing.code, 2);
  EXPECT_NE(nothing.err.find("neither a clip nor a photodiode"), std::string::npos) << nothing.err;
}

TEST_F(Cli, SiteWithTypoIsTwoAndNamesLineKeyAndNearest) {
  std::string text = content(kSample / "site.yaml");
  const auto place = text.find("focal_px");
  ASSERT_NE(place, std::string::npos);
  text.replace(place, 8, "focl_px");
  const fs::path bad = write("bad.yaml", text);
  const Ran ran = run("run" + clip() + " --site " + bad.string() + out());
  EXPECT_EQ(ran.code, 2);
  EXPECT_NE(ran.err.find("focl_px"), std::string::npos) << ran.err;
  EXPECT_NE(ran.err.find("focal_px"), std::string::npos) << ran.err;
  EXPECT_NE(ran.err.find("bad.yaml:"), std::string::npos) << ran.err;
  EXPECT_FALSE(fs::exists(folder_ / "out" / "speeds.csv"));
}

TEST_F(Cli, SiteOfAnotherImageSizeIsTwo) {
  std::string text = content(kSample / "site.yaml");
  const auto place = text.find("image_size_px");
  ASSERT_NE(place, std::string::npos);
  const auto end = text.find(']', place);
  text.replace(place, end + 1 - place, "image_size_px: [1280, 720]");
  const Ran ran = run("run" + clip() + " --site " + write("other.yaml", text).string() + out());
  EXPECT_EQ(ran.code, 2);
  EXPECT_NE(ran.err.find("image_size_px"), std::string::npos) << ran.err;
}

TEST_F(Cli, UnreadableClipIsThree) {
  EXPECT_EQ(run("run /nonexistent/clip.mp4" + site() + out()).code, 3);
  const Ran text = run("run " + write("text.mp4", "this is not a video\n").string() + site() + out());
  EXPECT_EQ(text.code, 3);
  EXPECT_NE(text.err.find("text.mp4"), std::string::npos) << text.err;
}

TEST_F(Cli, BrokenTraceBesideAGoodClipIsFourAndNamed) {
  const fs::path trace = write("trace.csv", "t_s,colour\n0,1\n");
  const Ran ran = run("run" + clip() + " --photodiode " + trace.string() + site() + out());
  EXPECT_EQ(ran.code, 4);
  EXPECT_NE(ran.err.find("trace.csv"), std::string::npos) << ran.err;
  EXPECT_TRUE(fs::exists(folder_ / "out" / "speeds.csv"));
  EXPECT_NE(content(folder_ / "out" / "run.json").find("trace.csv"), std::string::npos);
}

TEST_F(Cli, OutputBelowAFileIsFive) {
  const fs::path file = write("occupied", "x");
  const Ran ran = run("run" + clip() + site() + " --out " + (file / "sub").string());
  EXPECT_EQ(ran.code, 5);
  EXPECT_NE(ran.err.find("occupied"), std::string::npos) << ran.err;
}

TEST_F(Cli, JsonIsTheRunJsonAndNothingElse) {
  const Ran ran = run("run" + clip() + site() + out() + " --json");
  EXPECT_EQ(ran.code, 0) << ran.err;
  EXPECT_EQ(ran.out.front(), '{');
  EXPECT_NE(ran.out.find("\"vehicles\""), std::string::npos);
}

}  // namespace
}  // namespace vildar
