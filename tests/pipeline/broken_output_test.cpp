#include <sys/mount.h>
#include <sys/types.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <thread>

#include "pipeline/broken.h"

namespace vildar {
namespace {

using test::expect_told;
using test::Program;
using test::Ran;

class BrokenOutput : public Broken {
 protected:
  std::vector<std::string> words() const {
    return {(sample("straight") / "clip.mp4").string(), "--site",
            (sample("straight") / "site.yaml").string()};
  }
  Ran run_into(const std::filesystem::path& folder, const char* more = nullptr) const {
    std::vector<std::string> all = words();
    all.insert(all.begin(), "run");
    all.insert(all.end(), {"--out", folder.string()});
    if (more != nullptr) all.emplace_back(more);
    return Program(VILDAR_PROGRAM, all, folder_.path()).wait();
  }
};

/// A small file system in memory while the test lasts.
class SmallDisk {
 public:
  SmallDisk(std::filesystem::path at, const char* options) : at_(std::move(at)) {
    std::filesystem::create_directories(at_);
    error_ = ::mount("vildar_test", at_.c_str(), "tmpfs", 0, options) == 0 ? 0 : errno;
  }
  ~SmallDisk() {
    if (error_ == 0) ::umount(at_.c_str());
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
  /// False where it was refused.
  bool make_read_only() const {
    return ::mount("vildar_test", at_.c_str(), "tmpfs", MS_REMOUNT | MS_RDONLY, "") == 0;
  }
  const std::filesystem::path& path() const { return at_; }
  int error() const { return error_; }

 private:
  std::filesystem::path at_;
  int error_ = 0;
};

TEST_F(BrokenOutput, AFolderBelowAFileIsFive) {
  const std::string file = write("occupied", "x");
  expect_told(run_into(path("occupied") / "sub"), 5,
              {"occupied", "folder cannot be made", "choose a folder"});
  EXPECT_EQ(test::bytes_of(file), "x");
}

TEST_F(BrokenOutput, AnOutputThatIsAFolderIsFiveAndStays) {
  std::filesystem::create_directories(out() / "speeds.csv" / "kept");
  expect_told(run_into(out()), 5, {"speeds.csv", "is a folder, a device or a pipe"});
  EXPECT_TRUE(std::filesystem::exists(out() / "speeds.csv" / "kept"));
}

TEST_F(BrokenOutput, AReadOnlyDiskIsFive) {
  const SmallDisk disk(path("disk"), "size=1m");
  if (disk.error() != 0) GTEST_SKIP() << "a mount needs root: " << std::strerror(disk.error());
  ASSERT_TRUE(disk.make_read_only());
  expect_told(run_into(disk.path()), 5,
              {"disk", "cannot be written", "Read-only", "choose a folder"});
  expect_told(run_into(disk.path() / "sub"), 5, {"disk/sub", "folder cannot be made", "Read-only"});
}

TEST_F(BrokenOutput, AFullDiskIsFiveAndLeavesNoPartOfAFile) {
  const SmallDisk disk(path("disk"), "size=64k");
  if (disk.error() != 0) GTEST_SKIP() << "a mount needs root: " << std::strerror(disk.error());
  for (const char* more : {"--blobs", "--annotate"}) {
    expect_told(run_into(disk.path(), more), 5,
                {"disk", "No space left on device", "choose a folder"});
    EXPECT_TRUE(test::files_in(disk.path()).empty()) << more;
  }
}

TEST_F(BrokenOutput, WhatStoodThereBeforeAFailureStays) {
  const SmallDisk disk(path("disk"), "size=64k");
  if (disk.error() != 0) GTEST_SKIP() << "a mount needs root: " << std::strerror(disk.error());
  test::write_bytes(disk.path() / "tracks.csv", "of an earlier run\n");
  EXPECT_EQ(run_into(disk.path()).code, 5);
  EXPECT_EQ(test::bytes_of(disk.path() / "tracks.csv"), "of an earlier run\n");
}

TEST_F(BrokenOutput, ADiskThatFillsUpLateLeavesTheEarlierRunWhole) {
  constexpr std::uintmax_t kPage = 4096;
  const SmallDisk disk(path("disk"), "size=2m");
  if (disk.error() != 0) GTEST_SKIP() << "a mount needs root: " << std::strerror(disk.error());
  ASSERT_EQ(run_into(disk.path()).code, 0);
  std::uintmax_t needed = 0;
  for (const std::string& name : kOutputs)
    needed += (std::filesystem::file_size(disk.path() / name) / kPage + 1) * kPage;
  const std::uintmax_t last = std::filesystem::file_size(disk.path() / "run.json");
  for (const std::string& name : kOutputs)
    test::write_bytes(disk.path() / name, "of an earlier run\n");
  const std::uintmax_t free = std::filesystem::space(disk.path()).available;
  ASSERT_GT(free, needed);
  test::write_bytes(disk.path() / "filler", std::string(free - needed + last / 2, 'x'));
  expect_told(run_into(disk.path()), 5, {"run.json", "No space left on device"});
  for (const std::string& name : kOutputs)
    EXPECT_EQ(test::bytes_of(disk.path() / name), "of an earlier run\n") << name;
}

TEST_F(BrokenOutput, AnInputThatTheRunWouldReplaceIsTwoAndStays) {
  const std::filesystem::path clip = out() / "annotated.mp4", trace = out() / "speeds.csv";
  std::filesystem::create_directories(out());
  std::filesystem::copy_file(sample("straight") / "clip.mp4", clip);
  std::filesystem::create_hard_link(sample("straight") / "photodiode.csv", trace);
  const std::string bytes = test::bytes_of(clip);
  const std::string site_file = (sample("straight") / "site.yaml").string();
  expect_told(run({clip.string(), "--site", site_file}), 2,
              {"annotated.mp4", "is the clip to read", "another --out"});
  expect_told(run({(sample("straight") / "clip.mp4").string(), "--photodiode",
                   (sample("straight") / "photodiode.csv").string(), "--site", site_file}),
              2, {"photodiode.csv", "is the photodiode to read", "speeds.csv"});
  EXPECT_EQ(test::bytes_of(clip), bytes);
  EXPECT_FALSE(test::bytes_of(trace).empty());
}

TEST_F(BrokenOutput, AKilledRunLeavesNothingHalfWrittenUnderAFinalName) {
  std::vector<std::string> all = words();
  all.insert(all.begin(), "run");
  all.insert(all.end(), {"--out", out().string(), "--annotate", "--blobs"});
  for (const int signal : {SIGKILL, SIGTERM, SIGHUP}) {
    std::filesystem::remove_all(out());
    Program program(VILDAR_PROGRAM, all, folder_.path());
    while (program.running() && test::files_in(out()).empty())
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    ::kill(program.pid(), signal);
    const Ran ran = program.wait();
    if (signal == SIGKILL) {
      ASSERT_EQ(ran.signal, SIGKILL) << "the run ended before it was killed";
    } else {
      expect_told(ran, 128 + signal, {"interrupted"});
    }
    for (const std::string& name : test::files_in(out()))
      EXPECT_TRUE(signal == SIGKILL && name.front() == '.') << name;
  }
}

TEST_F(BrokenOutput, ASceneIsNotRenderedOverTheSiteFileItNames) {
  const std::filesystem::path given = sample("straight") / "scenario.yaml";
  for (const char* name : {"scenario.yaml", "site.yaml"}) {
    const std::filesystem::path folder = path("scene_" + std::string(name));
    std::filesystem::create_directories(folder);
    const std::string text = test::bytes_of(given);
    test::write_bytes(folder / name, text);
    const bool is_site = std::string(name) == "site.yaml";
    if (!is_site) {
      test::write_bytes(folder / "site.yaml", test::bytes_of(sample("straight") / "site.yaml"));
      test::write_bytes(folder / name, "site: site.yaml\nduration_s: 0.2\nvehicles: []\n");
    }
    const std::string site = test::bytes_of(folder / "site.yaml");
    expect_told(
        Program(VILDAR_PROGRAM, {"render", (folder / name).string(), "--out", folder.string()},
                folder_.path())
            .wait(),
        2, {"site.yaml", "is read", "choose another --out"});
    EXPECT_EQ(test::bytes_of(folder / "site.yaml"), site);
  }
}

TEST_F(BrokenOutput, ACalibrationReplacesNothingThatItsRunsWereGiven) {
  const std::string trace = write("night.csv", "t_s,power_w\n0,1\n");
  std::filesystem::create_directories(path("night"));
  test::write_bytes(path("night") / "run.json",
                    R"({"inputs": [{"role": "photodiode", "path": ")" + trace + R"("}]})");
  for (const char* what : {"photodiode", "mount"}) {
    expect_told(Program(VILDAR_PROGRAM,
                        {"calibrate", what, path("night").string(), "--site",
                         (sample("straight") / "site.yaml").string(), "--out", trace},
                        folder_.path())
                    .wait(),
                2, {"night.csv", "is read", "choose another --out"});
    EXPECT_EQ(test::bytes_of(trace), "t_s,power_w\n0,1\n");
  }
}

TEST_F(BrokenOutput, TwoRunsOfOneClipAreNotCalibratedFrom) {
  for (const char* folder : {"one", "other"}) {
    std::filesystem::create_directories(path(folder));
    test::write_bytes(path(folder) / "run.json",
                      R"({"inputs": [{"role": "clip", "path": "night.mp4", "sha256": "ab"}]})");
  }
  expect_told(
      Program(VILDAR_PROGRAM,
              {"calibrate", "mount", path("one").string(), path("other").string(), "--site",
               (sample("straight") / "site.yaml").string(), "--out", path("learned.yaml").string()},
              folder_.path())
          .wait(),
      2, {"other", "its clip is that of", "count twice"});
}

}  // namespace
}  // namespace vildar
