#include "pipelines/interrupt.h"

namespace vildar {
namespace {

volatile std::sig_atomic_t received_signal = 0;

extern "C" void remember_signal(int signal) { received_signal = signal; }

}  // namespace

InterruptScope::InterruptScope() {
  received_signal = 0;
  struct sigaction once {};
  once.sa_handler = remember_signal;
  once.sa_flags = SA_RESETHAND | SA_RESTART;
  ::sigemptyset(&once.sa_mask);
  ::sigaction(SIGINT, &once, &on_interrupt_before_);
  ::sigaction(SIGTERM, &once, &on_terminate_before_);
  ::sigaction(SIGHUP, &once, &on_hang_up_before_);
}

InterruptScope::~InterruptScope() {
  ::sigaction(SIGINT, &on_interrupt_before_, nullptr);
  ::sigaction(SIGTERM, &on_terminate_before_, nullptr);
  ::sigaction(SIGHUP, &on_hang_up_before_, nullptr);
}

void throw_if_interrupted() {
  if (received_signal != 0) throw Interrupted(received_signal);
}

}  // namespace vildar
