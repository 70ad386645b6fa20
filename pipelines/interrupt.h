#pragma once

#include <stdexcept>

namespace vildar {

/// Signal handler: the next throw_if_interrupted() throws, so that unfinished files are removed.
extern "C" void request_interrupt(int signal);

class Interrupted : public std::runtime_error {
 public:
  Interrupted() : std::runtime_error("interrupted; nothing was written") {}
};

void throw_if_interrupted();

}  // namespace vildar
