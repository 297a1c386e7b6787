#include "client/cli/interrupts.h"

#include <pthread.h>

#include <cstdlib>

#include "client/cli/command_line.h"

namespace burnish::cli {

Interrupts::Interrupts() {
  sigemptyset(&signals_);
  sigaddset(&signals_, SIGINT);
  sigaddset(&signals_, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals_, &previous_);
  watcher_ = std::thread([this] { watch(); });
}

Interrupts::~Interrupts() {
  closing_ = true;
  // Wakes sigwait; the signal is blocked, so it ends no thread.
  pthread_kill(watcher_.native_handle(), SIGTERM);  // NOLINT(bugprone-bad-signal-to-kill-thread)
  watcher_.join();
  pthread_sigmask(SIG_SETMASK, &previous_, nullptr);
}

void Interrupts::watch() {
  for (;;) {
    int signal = 0;
    sigwait(&signals_, &signal);
    if (closing_) return;
    if (stop_.stop_requested()) std::_Exit(kInterrupted);
    stop_.request_stop();
  }
}

}  // namespace burnish::cli
