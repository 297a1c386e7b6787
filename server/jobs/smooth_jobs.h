// What both transports do with a request to smooth: check, queue, run, count, log, answer.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "server/jobs/job_runner.h"
#include "server/lifecycle.h"
#include "server/observe/metrics.h"
#include "server/service/smooth_service.h"

namespace burnish {

/// Sixteen random hexadecimal digits.
std::string new_request_id();

using SmoothFunction = std::function<Result<SmoothResult>(const SmoothJob&, const RunControl&)>;

/// Thread-safe; its arguments must outlive it, and the runner must be drained before it goes.
class SmoothJobs {
 public:
  using Clock = RunControl::Clock;
  using Done = std::function<void(Result<SmoothResult>)>;

  /// `longest_run` bounds the time of every run. `smooth` stands in for service.smooth() in tests.
  SmoothJobs(const SmoothService& service, JobRunner& runner, const Lifecycle& lifecycle, Metrics& metrics,
             std::chrono::milliseconds longest_run, SmoothFunction smooth = {});

  /// Calls `done` exactly once: on this thread before it returns when the job is refused (then there is no
  /// handle), else on a worker, or on the thread that cancels or refuses the waiting job. What job's views
  /// point to must live until then: keep it in `done`. Errors: those of SmoothService, QueueFull,
  /// ShuttingDown.
  std::optional<JobHandle> submit(Transport transport, SmoothJob job,
                                  std::optional<Clock::time_point> deadline, Done done);

  /// Counts and logs a request that its transport refused before it became a job.
  void record_refusal(Transport transport, std::string_view request_id, const Error& error);

  const Limits& limits() const { return service_.limits(); }
  bool serving() const { return lifecycle_.serving(); }
  std::string metrics_text() { return metrics_.text(runner_.queued(), runner_.running()); }

 private:
  struct Call;
  Result<> admit(const SmoothJob& job) const;
  void run(Call& call, const RunControl& run, double queue_ms);
  Result<SmoothResult> smooth(const SmoothJob& job, const RunControl& run) const;
  void finish(Call& call, Result<SmoothResult> result);

  const SmoothService& service_;
  JobRunner& runner_;
  const Lifecycle& lifecycle_;
  Metrics& metrics_;
  const std::chrono::milliseconds longest_run_;
  const SmoothFunction smooth_;
};

}  // namespace burnish
