#include <sys/wait.h>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

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
    const int status = std::system((std::string(VILDAR_PROGRAM) + " " + arguments + " >" +
                                    out.string() + " 2>" + err.string() + " </dev/null")
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
  for (const char* command : {"run", "render", "evaluate", "simulate", "calibrate"}) {
    const Ran help = run(std::string(command) + " --help");
    EXPECT_EQ(help.code, 0) << command;
    const auto examples = help.out.find("Example");
    ASSERT_NE(examples, std::string::npos) << help.out;
    EXPECT_NE(help.out.find("vildar " + std::string(command), examples), std::string::npos);
  }
}

TEST_F(Cli, WrongUsageIsTwo) {
  EXPECT_EQ(run("").code, 2);
  EXPECT_EQ(run("run").code, 2);
  EXPECT_EQ(run("run --nonsense").code, 2);
  for (const char* words : {"rnu clip.mp4", "rnu --help"}) {
    const auto unknown = run(words);
    EXPECT_EQ(unknown.code, 2) << words;
    EXPECT_NE(unknown.err.find("\"rnu\" is no subcommand"), std::string::npos) << unknown.err;
    EXPECT_NE(unknown.err.find("run, render"), std::string::npos) << unknown.err;
  }
  for (const char* words : {"run clip.mp4 --site site.yaml --out ''", "render '' --out there"}) {
    const auto empty = run(words);
    EXPECT_EQ(empty.code, 2) << words;
    EXPECT_NE(empty.err.find("is empty"), std::string::npos) << empty.err;
  }
  for (const char* words : {"render --random 1 --seed -1 --scenario-only --out there",
                            "simulate straight-duration --seed -1 --out there"}) {
    const auto negative = run(words);
    EXPECT_EQ(negative.code, 2) << words;
    EXPECT_NE(negative.err.find("--seed"), std::string::npos) << negative.err;
  }
  const Ran blank = run("simulate straight-duration --snr-db nan --out there");
  EXPECT_EQ(blank.code, 2);
  EXPECT_NE(blank.err.find("SNR = nan"), std::string::npos) << blank.err;
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
  const Ran text =
      run("run " + write("text.mp4", "this is not a video\n").string() + site() + out());
  EXPECT_EQ(text.code, 3);
  EXPECT_NE(text.err.find("text.mp4"), std::string::npos) << text.err;
}

TEST_F(Cli, BrokenTraceBesideAGoodClipIsFourAndNamed) {
  const fs::path trace = write("trace.csv", "t_s,colour\n0,1\n");
  const Ran ran = run("run" + clip() + " --photodiode " + trace.string() + site() + out());
  EXPECT_EQ(ran.code, 4);
  EXPECT_NE(ran.err.find("trace.csv"), std::string::npos) << ran.err;
  EXPECT_TRUE(fs::exists(folder_ / "out" / "speeds.csv"));
  const nlohmann::json json = nlohmann::json::parse(content(folder_ / "out" / "run.json"));
  EXPECT_NE(json.at("warnings").dump().find("trace.csv"), std::string::npos) << json.at("warnings");
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
  EXPECT_EQ(ran.out, content(folder_ / "out" / "run.json"));
  EXPECT_EQ(nlohmann::json::parse(ran.out).at("vehicles").size(), 4u);
}

TEST_F(Cli, WhatAnEarlierRunLeftDoesNotStandBesideTheNew) {
  fs::create_directories(folder_ / "out");
  for (const char* name : {"out/annotated.mp4", "out/blobs.csv", "out/notes.txt"})
    write(name, "old");
  EXPECT_EQ(run("run" + clip() + site() + out()).code, 0);
  EXPECT_FALSE(fs::exists(folder_ / "out/annotated.mp4"));
  EXPECT_FALSE(fs::exists(folder_ / "out/blobs.csv"));
  EXPECT_EQ(content(folder_ / "out/notes.txt"), "old") << "not ours to remove";
}

TEST_F(Cli, StandardOutputThatIsFullIsFive) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full on this system";
  const std::string command = std::string(VILDAR_PROGRAM) + " run" + clip() + site() + out() +
                              " --json >/dev/full 2>" + (folder_ / "stderr").string();
  EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 5);
  EXPECT_NE(content(folder_ / "stderr").find("standard output"), std::string::npos);
}

TEST_F(Cli, InterruptedRenderingLeavesNothingHalfWritten) {
  const fs::path scene = folder_ / "scene", code = folder_ / "code";
  const std::string script =
      std::string(VILDAR_PROGRAM) + " render " + (kSample / "scenario.yaml").string() + " --out " +
      scene.string() + " >/dev/null 2>&1 & pid=$!; for i in $(seq 600); do ls " + scene.string() +
      "/.clip* >/dev/null 2>&1 && break; sleep 0.05; done; kill -TERM $pid; wait $pid; echo $? >" +
      code.string();
  std::system(("bash -c '" + script + "'").c_str());
  EXPECT_EQ(content(code), "143\n");
  EXPECT_FALSE(fs::exists(scene / "clip.mp4"));
  for (const fs::directory_entry& entry : fs::directory_iterator(scene))
    EXPECT_NE(entry.path().filename().string().front(), '.') << entry.path() << " is half a file";
}

TEST_F(Cli, SimulationsEndAtOnceWhenToldTo) {
  const fs::path code = folder_ / "code";
  const std::string script =
      std::string(VILDAR_PROGRAM) + " simulate all --out " + (folder_ / "paper").string() +
      " >/dev/null 2>&1 & pid=$!; sleep 0.5; kill -TERM $pid; wait $pid; echo $? >" + code.string();
  std::system(("bash -c '" + script + "'").c_str());
  EXPECT_EQ(content(code), "143\n");
}

}  // namespace
}  // namespace vildar
