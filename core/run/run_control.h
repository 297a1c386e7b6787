// How a caller steers work that is under way: stop it, bound its time, watch its progress, choose its
// threads.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <stop_token>

#include "core/run/error.h"

namespace burnish {

/// Passed by const reference through every long function. Loops ask stopped() once per block of work, so a
/// stop is noticed within milliseconds. Thread-safe: stopped() may be called from any thread.
struct RunControl {
  using Clock = std::chrono::steady_clock;

  std::stop_token stop = {};
  std::optional<Clock::time_point> deadline = {};
  /// Called from the thread that runs the job, with the fraction done in [0, 1]; must not block.
  std::function<void(double fraction)> progress = {};
  /// Threads that the job may use, at most one per core; 0 means every core. Any number gives the same
  /// result.
  unsigned threads = 1;

  bool stopped() const noexcept { return stop.stop_requested() || (deadline && Clock::now() >= *deadline); }

  /// The same job on one thread: for loops whose steps depend on each other.
  RunControl on_one_thread() const {
    RunControl run = *this;
    run.threads = 1;
    return run;
  }

  /// Why stopped() is true: Cancelled before DeadlineExceeded when both hold.
  Error stop_error() const {
    if (stop.stop_requested()) return {Cause::Cancelled, "the caller cancelled the job"};
    return {Cause::DeadlineExceeded, "the deadline passed before the job was done"};
  }

  /// Ok while the job may go on.
  Result<> check() const {
    if (stopped()) return stop_error();
    return {};
  }

  void report(double fraction) const {
    if (progress) progress(fraction);
  }
};

}  // namespace burnish
