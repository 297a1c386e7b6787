// What both transports do with a request to smooth or to compare: check, queue, run, count, log, answer.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "server/jobs/job_runner.h"
#include "server/jobs/spool.h"
#include "server/lifecycle.h"
#include "server/observe/metrics.h"
#include "server/security/tokens.h"
#include "server/service/smooth_service.h"

namespace burnish {

/// Sixteen random hexadecimal digits.
std::string new_request_id();

/// Who asks, and for whom: for the log, the metrics and what only its owner may see.
struct Caller {
  Transport transport = Transport::Grpc;
  Kind kind = Kind::Smooth;  ///< of what was refused; smooth() and compare() know theirs
  std::string request_id = new_request_id();
  std::string trace_id = {};          ///< of a W3C traceparent; empty: none
  std::string owner = {};             ///< whose token came with it; empty: the server asks for none
  Quota quota = {};                   ///< of this owner
  std::optional<Error> refusal = {};  ///< why nothing will be done for this caller
  std::optional<RunControl::Clock::time_point> deadline = {};
  bool low = false;   ///< its jobs go after all that are not
  bool kept = false;  ///< its job is on disk already: as in JobWork
};

/// Thread-safe; its arguments must outlive it, and the runner must be drained before it goes.
class Jobs {
 public:
  using Clock = RunControl::Clock;
  template <class Answer>
  using Done = std::function<void(Result<Answer>)>;

  /// `smooth` and `compare` stand in for those of the service.
  Jobs(const SmoothService& service, JobRunner& runner, Spool& spool, const Lifecycle& lifecycle,
       Metrics& metrics, SmoothFunction smooth = {}, CompareFunction compare = {});

  /// Calls `done` exactly once: on this thread before it returns when the job is refused (then there is no
  /// handle), else on a worker, or on the thread that cancels or refuses the waiting job. What job's views
  /// point to must live until then: keep it in `done`. Sets the job's request_id. Errors: those of
  /// SmoothService and JobRunner::submit().
  std::optional<JobHandle> smooth(const Caller& caller, SmoothJob job, Done<SmoothResult> done);
  std::optional<JobHandle> compare(const Caller& caller, CompareJob job, Done<v1::CompareResponse> done);

  /// Whether a request of `bytes` (0: not known yet) that starts to arrive now has a chance, so that one that
  /// has none is refused before its bytes are read. Errors: ShuttingDown, TooLarge, QueueFull, MemoryFull,
  /// DeadlineExceeded.
  Result<> expect(const Caller& caller, std::uint64_t mesh_bytes, std::uint64_t reference_bytes) const;

  /// What smooth() would say now.
  Result<> would_take(const Caller& caller, const SmoothJob& job) const;
  /// Of one core.
  std::chrono::duration<double> expected_seconds(const SmoothJob& job) const;

  /// Counts and logs a request that its transport refused before it became a job.
  void record_refusal(const Caller& caller, const Error& error);

  /// A tiny mesh through the queue, a worker and the service; what readiness rests on at start.
  Result<> self_test();

  /// Asks for tokens from now on; to be set before anybody calls, null: for none.
  void ask_for(Tokens* tokens) { tokens_ = tokens; }
  /// Of this server among several, so that a balancer finds what it keeps; to be set before anybody calls.
  void name_replica(std::string name) { replica_ = std::move(name); }
  /// Of a job or an upload: 32 random hexadecimal digits, after the replica's name and a hyphen when it has
  /// one.
  std::string new_kept_id() const;
  /// Who the caller is by an Authorization header or metadata; or why it is refused: Unauthenticated,
  /// QuotaExceeded. `counts`: the first time that this request asks.
  void identify(std::string_view authorization, Caller& caller, bool counts = true) const;
  /// Counts bytes of a mesh, which has `whole` bytes by now, against the caller's quotas. Errors:
  /// QuotaExceeded, and what refuses this caller.
  Result<> charge(const Caller& caller, std::uint64_t bytes, std::uint64_t whole) const;

  /// Where transports keep the bytes that arrive.
  Spool& spool() { return spool_; }
  const SmoothService& service() const { return service_; }
  const RequestLimits& limits() const { return service_.limits(); }
  /// Takes work: the lifecycle says so and the workers turn. Never waits.
  bool serving() const { return lifecycle_.serving() && runner_.healthy(); }
  std::size_t workers() const { return runner_.workers(); }
  std::string metrics_text();
  /// Fills in what this knows nothing of; to be set before anybody asks for metrics.
  void set_more_gauges(std::function<void(Gauges&)> fill) { more_gauges_ = std::move(fill); }

 private:
  template <class Job, class Answer>
  struct Call;
  template <class Job, class Answer>
  std::optional<JobHandle> submit(const Caller& caller, Job job, Done<Answer> done);
  template <class Job>
  Result<> admit(const Caller& caller, const Job& job) const;
  template <class Job, class Answer>
  void run(Call<Job, Answer>& call, const RunControl& control, double queue_ms);
  template <class Job, class Answer>
  void finish(Call<Job, Answer>& call, Result<Answer> result);
  Result<SmoothResult> perform(const SmoothJob& job, const RunControl& run) const;
  Result<v1::CompareResponse> perform(const CompareJob& job, const RunControl& run) const;

  const SmoothService& service_;
  JobRunner& runner_;
  Spool& spool_;
  const Lifecycle& lifecycle_;
  Metrics& metrics_;
  const SmoothFunction smooth_;
  const CompareFunction compare_;
  Tokens* tokens_ = nullptr;
  std::string replica_;
  std::function<void(Gauges&)> more_gauges_ = [](Gauges&) {};
};

}  // namespace burnish
