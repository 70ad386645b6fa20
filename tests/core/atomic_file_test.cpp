#include "core/atomic_file.h"

#include <sys/stat.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <iterator>

#include "core/error.h"
#include "support/temporary_folder.h"

namespace vildar {
namespace {

std::string content(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::size_t files_in(const std::filesystem::path& folder) {
  std::size_t count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder)) ++count;
  return count;
}

TEST(AtomicFile, AppearsWholeOnCommitAndNotBefore) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "new/deep/out.csv";
  AtomicFile file(path);
  file.write("a,b\n");
  file.write(std::string(1 << 20, 'x'));
  EXPECT_FALSE(std::filesystem::exists(path));
  file.commit();
  EXPECT_EQ(content(path), "a,b\n" + std::string(1 << 20, 'x'));
  EXPECT_EQ(files_in(path.parent_path()), 1u);
}

TEST(AtomicFile, WithoutCommitTheOldFileStaysAndNothingElse) {
  const TemporaryFolder folder;
  const auto path = folder.write("out.csv", "old");
  {
    AtomicFile file(path);
    file.write("new");
    EXPECT_EQ(content(path), "old");
    EXPECT_EQ(files_in(folder.path()), 2u);
  }
  EXPECT_EQ(content(path), "old");
  EXPECT_EQ(files_in(folder.path()), 1u);
}

TEST(AtomicFile, ReplacesTheOldFileWhole) {
  const TemporaryFolder folder;
  const auto path = folder.write("out.csv", "a longer text than the new one");
  write_file_atomically(path, "new");
  EXPECT_EQ(content(path), "new");
}

TEST(AtomicFile, OthersMayWriteThePartItself) {
  const TemporaryFolder folder;
  AtomicFile file(folder.path() / "clip.mp4");
  EXPECT_EQ(file.part_path().extension(), ".mp4");
  EXPECT_EQ(file.part_path().parent_path(), folder.path());
  std::ofstream(file.part_path()) << "written by a muxer";
  file.commit();
  EXPECT_EQ(content(file.path()), "written by a muxer");
}

TEST(AtomicFile, APlaceThatCannotHoldItIsAnOutputErrorNamingIt) {
  const TemporaryFolder folder;
  const auto plain = folder.write("plain", "");
  try {
    AtomicFile file(plain / "out.csv");
    ADD_FAILURE() << "a file was made below a file";
  } catch (const OutputError& error) {
    EXPECT_NE(std::string(error.what()).find(plain.string()), std::string::npos);
  }
  std::filesystem::create_directory(folder.path() / "folder");
  EXPECT_THROW(write_file_atomically(folder.path() / "folder", "text"), OutputError);
  EXPECT_EQ(files_in(folder.path()), 2u);  // no part left behind
}

TEST(AtomicFile, APipeIsNotReplaced) {
  const TemporaryFolder folder;
  const auto pipe = folder.path() / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THROW(write_file_atomically(pipe, "text"), OutputError);
  EXPECT_TRUE(std::filesystem::is_fifo(pipe));
}

TEST(AtomicFile, APartThatWasTakenAwayIsAnOutputError) {
  const TemporaryFolder folder;
  AtomicFile file(folder.path() / "out.csv");
  std::filesystem::remove(file.part_path());
  EXPECT_THROW(file.commit(), OutputError);
  EXPECT_EQ(files_in(folder.path()), 0u);
}

// By runs that were killed; another that goes on, or one on another machine, keeps its own.
TEST(AtomicFile, WhatKilledRunsLeftIsRemovedAfterADay) {
  const TemporaryFolder folder;
  constexpr int kNoProcess = 2'000'000'000;  // beyond what Linux numbers
  const auto left = [&](const std::string& name, int process, int hours) {
    const auto file = folder.path() / ("." + name + "." + std::to_string(process) + ".part.csv");
    std::ofstream(file) << "a,b\n";
    std::filesystem::last_write_time(
        file, std::filesystem::file_time_type::clock::now() - std::chrono::hours(hours));
    return file;
  };
  const auto killed = left("out", kNoProcess, 25), lately = left("out", kNoProcess + 1, 23),
             living = left("out", ::getppid(), 25), other = left("out2", kNoProcess, 25);
  write_file_atomically(folder.path() / "out.csv", "1,2\n");
  EXPECT_FALSE(std::filesystem::exists(killed));
  EXPECT_TRUE(std::filesystem::exists(lately));
  EXPECT_TRUE(std::filesystem::exists(living));
  EXPECT_TRUE(std::filesystem::exists(other));
}

}  // namespace
}  // namespace vildar
