// Work that waits to be let go, so that tests decide when a job runs and when it ends.
#pragma once

#include <condition_variable>
#include <future>
#include <mutex>
#include <optional>
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

/// How a job ended: the cause that refused or stopped it, or nothing when it finished.
using Ending = std::optional<Cause>;

/// A job that waits at a gate, and the promise of its end.
struct GatedJob {
  std::promise<Ending> promise;
  std::future<Ending> end = promise.get_future();

  JobWork work(Gate& gate) {
    return {.run =
                [this, &gate](const RunControl& run, double) {
                  promise.set_value(gate.pass(run) ? Ending() : Ending(run.stop_error().cause));
                },
            .refuse = [this](const Error& error) { promise.set_value(error.cause); }};
  }
};

}  // namespace burnish::testing
