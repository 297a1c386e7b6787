// Work that waits to be let go, so that tests decide when a job runs and when it ends.
#pragma once

#include <condition_variable>
#include <mutex>
#include <string>

#include "server/jobs/jobs.h"

namespace burnish::testing {

class Gate {
 public:
  /// Waits until open() or until the run is stopped; false when stopped.
  bool pass(const RunControl& run) {
    std::unique_lock lock(mutex_);
    ++entered_;
    changed_.notify_all();
    while (!open_ && !run.stopped()) changed_.wait_for(lock, std::chrono::milliseconds(1));
    return open_;
  }

  void open() {
    const std::lock_guard lock(mutex_);
    open_ = true;
    changed_.notify_all();
  }

  /// Waits until `jobs` have come to the gate.
  void wait_for(int jobs) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return entered_ >= jobs; });
  }

  /// A smoother that waits at the gate, then returns its input as it is.
  SmoothFunction smoother() {
    return [this](const SmoothJob& job, const RunControl& run) -> Result<SmoothResult> {
      if (!pass(run)) return run.stop_error();
      SmoothResult result;
      result.mesh = job.mesh;
      result.report.set_request_id(job.request_id);
      return result;
    };
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  int entered_ = 0;
  bool open_ = false;
};

}  // namespace burnish::testing
