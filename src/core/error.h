#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace vildar {

/// One thing wrong in a file that a person wrote: which file, where, what, and what to do.
struct Problem {
  std::string file;
  int line = 0;        ///< 1-based; 0 where the file as a whole is meant
  std::string key;     ///< full path, e.g. `photodiodes[1].area_m2`; empty where none applies
  std::string fault;   ///< what is wrong, with the value found
  std::string remedy;  ///< what to do, e.g. `did you mean "area_m2"?`; may be empty
};

/// "file:line: key: fault; remedy", on one line.
std::string to_string(const Problem& problem);

/// A site, scenario or manifest file that does not hold to its rules; carries every problem found.
class ConfigError : public std::runtime_error {
 public:
  explicit ConfigError(std::vector<Problem> problems);
  const std::vector<Problem>& problems() const { return problems_; }

 private:
  std::vector<Problem> problems_;
};

/// An input (clip, trace) of which nothing can be read. The message names file, fault and remedy.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// An output that cannot be written. The message names file, fault and remedy.
class OutputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace vildar
