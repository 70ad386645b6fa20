#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

namespace vildar {

/// A one-line progress bar on standard error, drawn only when that is a terminal, at most ten times
/// a second; the line is wiped at the end.
class Progress {
 public:
  /// `units` names what is counted, e.g. "frames".
  Progress(std::string what, std::optional<std::int64_t> total, std::string units);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void update(std::int64_t done);

 private:
  std::string what_;
  std::optional<std::int64_t> total_;
  std::string units_;
  bool terminal_;
  std::chrono::steady_clock::time_point started_;
  std::chrono::steady_clock::time_point drawn_;
};

}  // namespace vildar
