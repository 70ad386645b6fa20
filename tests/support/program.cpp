#include "support/program.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <stdexcept>

#include "support/file_bytes.h"

namespace vildar::test {

Program::Program(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                 const std::filesystem::path& folder)
    : out_(folder / "stdout"), err_(folder / "stderr") {
  std::vector<std::string> words{program.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  pid_ = ::fork();
  if (pid_ < 0) throw std::runtime_error("cannot fork");
  if (pid_ > 0) return;
  const int in = ::open("/dev/null", O_RDONLY);
  const int out = ::open(out_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  const int err = ::open(err_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  if (in < 0 || out < 0 || err < 0) ::_exit(126);
  ::dup2(in, 0);
  ::dup2(out, 1);
  ::dup2(err, 2);
  ::execv(program.c_str(), argv.data());
  ::_exit(127);
}

Program::~Program() {
  if (ended_) return;
  ::kill(pid_, SIGKILL);
  ::waitpid(pid_, &status_, 0);
}

bool Program::running() {
  if (!ended_) ended_ = ::waitpid(pid_, &status_, WNOHANG) == pid_;
  return !ended_;
}

Ran Program::wait() {
  if (!ended_) ::waitpid(pid_, &status_, 0);
  ended_ = true;
  Ran ran{-1, 0, bytes_of(out_), bytes_of(err_)};
  if (WIFEXITED(status_)) ran.code = WEXITSTATUS(status_);
  if (WIFSIGNALED(status_)) ran.signal = WTERMSIG(status_);
  return ran;
}

void expect_told(const Ran& ran, int code, std::initializer_list<const char*> words) {
  EXPECT_EQ(ran.code, code) << ran.err;
  EXPECT_EQ(ran.signal, 0) << ran.err;
  for (const char* word : words)
    EXPECT_NE(ran.err.find(word), std::string::npos) << "not told: " << word << "\n" << ran.err;
}

std::vector<std::string> files_in(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(folder, none))
    names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace vildar::test
