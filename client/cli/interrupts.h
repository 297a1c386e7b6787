// Ctrl-C and SIGTERM as a stop token.
#pragma once

#include <atomic>
#include <csignal>
#include <stop_token>
#include <thread>

namespace burnish::cli {

/// The first signal trips the token, so that work ends cleanly; a second one ends the process at once.
/// Create it before any other thread: threads inherit the blocked signals. Restores the mask when destroyed.
class Interrupts {
 public:
  Interrupts();
  ~Interrupts();
  Interrupts(const Interrupts&) = delete;
  Interrupts& operator=(const Interrupts&) = delete;

  std::stop_token token() const { return stop_.get_token(); }

 private:
  void watch();

  sigset_t signals_{}, previous_{};
  std::stop_source stop_;
  std::atomic<bool> closing_ = false;
  std::thread watcher_;  // last: it uses the others
};

}  // namespace burnish::cli
