#pragma once

#include <sys/types.h>

#include <filesystem>
#include <initializer_list>
#include <string>
#include <vector>

#include "support/temporary_folder.h"

namespace vildar::test {

/// How a program ended and what it said.
struct Ran {
  int code = -1;   ///< exit code; -1 where a signal ended it
  int signal = 0;  ///< that signal
  std::string out, err;
};

/// A program started and not yet waited for; its output goes to files in `folder`.
class Program {
 public:
  Program(const std::filesystem::path& program, const std::vector<std::string>& arguments,
          const std::filesystem::path& folder);
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;
  ~Program();

  pid_t pid() const { return pid_; }
  bool running();
  Ran wait();

 private:
  std::filesystem::path out_, err_;
  pid_t pid_ = -1;
  bool ended_ = false;
  int status_ = 0;
};

/// Fails the test unless the run gave `code` and its standard error holds every one of `words`.
void expect_told(const Ran& ran, int code, std::initializer_list<const char*> words);

/// Names of the files in a folder, hidden ones too, in order; none where there is no folder.
std::vector<std::string> files_in(const std::filesystem::path& folder);

}  // namespace vildar::test
