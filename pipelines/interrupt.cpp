#include "pipelines/interrupt.h"

#include <csignal>

namespace vildar {
namespace {
volatile std::sig_atomic_t interrupted = 0;
}

extern "C" void request_interrupt(int) { interrupted = 1; }

void throw_if_interrupted() {
  if (interrupted != 0) throw Interrupted();
}

}  // namespace vildar
