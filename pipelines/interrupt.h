#pragma once

#include <csignal>
#include <stdexcept>

namespace vildar {

/// What throw_if_interrupted() throws; main() ends with 128 plus the signal's number, as shells do.
class Interrupted : public std::runtime_error {
 public:
  explicit Interrupted(int signal)
      : std::runtime_error("interrupted; unfinished files were removed"), signal_(signal) {}
  int signal() const { return signal_; }

 private:
  int signal_;
};

/// While it lives, the first SIGINT, SIGTERM or SIGHUP lets the work end at its next
/// throw_if_interrupted(), so that unfinished files are removed; a second one ends the program at
/// once. Outside of it signals do what they do by default. One at a time.
class InterruptScope {
 public:
  InterruptScope();
  ~InterruptScope();
  InterruptScope(const InterruptScope&) = delete;
  InterruptScope& operator=(const InterruptScope&) = delete;

 private:
  struct sigaction on_interrupt_before_;
  struct sigaction on_terminate_before_;
  struct sigaction on_hang_up_before_;
};

void throw_if_interrupted();

}  // namespace vildar
