// The bounded queue and the worker pool, apart from both transports' threads.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>
#include <vector>

#include "core/run/run_control.h"
#include "server/jobs/fair_line.h"
#include "server/jobs/pace.h"
#include "server/jobs/retry_times.h"

namespace burnish {

/// What a job is while it waits and runs. `run` is called once on a worker; `refuse` instead of it when the
/// job is cancelled, its deadline passes or the grace period ends before a worker takes it. Exactly one of
/// the two is called.
struct JobWork {
  std::function<void(const RunControl& run, double queue_ms)> run;
  std::function<void(const Error& error)> refuse;
  Turn turn = {};
  /// On disk already, and not many at once: it has a place in the queue whatever else waits, and when memory
  /// is short it comes before what arrives later.
  bool kept = false;
};

/// What a job is expected to take.
struct JobCost {
  std::uint64_t bytes = 0;  ///< of memory while it is in the server
  double work = 0;          ///< proportional to its run time; 0 = not known
};

class JobRunner;

/// Stops one job; thread-safe and safe to repeat. A queued job is refused with Cancelled at once, on the
/// calling thread; a running one sees its stop token.
class JobHandle {
 public:
  void cancel();

 private:
  friend class JobRunner;
  struct Job;
  JobHandle(std::shared_ptr<Job> job, JobRunner* runner) : job_(std::move(job)), runner_(runner) {}
  std::shared_ptr<Job> job_;
  JobRunner* runner_;
};

struct JobRunnerOptions {
  unsigned workers = 0;    ///< jobs that run at once; 0 = one per core
  std::size_t queue = 64;  ///< jobs that may wait; more are refused at once
  /// What they and those that run are expected to take; what would wait behind more is refused. 0 = any.
  std::chrono::seconds queue_seconds{0};
  unsigned threads = 0;  ///< cores that one job may use when it is alone; 0 = all
  std::uint64_t max_memory = std::uint64_t{4} << 30;  ///< sum of JobCost::bytes
  std::chrono::milliseconds longest_run{600'000};     ///< of one job
  /// A job that runs on for so long after its end was asked for counts as stuck; library calls that cannot be
  /// interrupted take seconds.
  std::chrono::milliseconds overrun{30'000};
};

/// One job runs on one core while others wait or run; a job that starts alone uses every core. Owners have
/// their turns one after the other, and none may fill more places of the queue than it leaves free to others.
class JobRunner {
 public:
  explicit JobRunner(const JobRunnerOptions& options);
  ~JobRunner();  ///< drain(zero)
  JobRunner(const JobRunner&) = delete;
  JobRunner& operator=(const JobRunner&) = delete;

  /// Queues a job. Errors: QueueFull and MemoryFull with the time after which to come back,
  /// ShuttingDown, TooLarge for a job that needs more than all memory, DeadlineExceeded when the jobs before
  /// it are expected to take too long; then neither function of `work` is called.
  Result<JobHandle> submit(JobWork work, const JobCost& cost,
                           std::optional<RunControl::Clock::time_point> deadline);

  /// What submit() would say now, for requests whose bytes are still to come. `kept`: as in JobWork; the
  /// memory that it lacks is then kept free for it until it asks again, for a second.
  Result<> would_take(const JobCost& cost, std::optional<RunControl::Clock::time_point> deadline,
                      const Turn& turn = {}, bool kept = false);

  /// What a job of so much work takes; a guess from the work alone before the first one ran.
  std::chrono::duration<double> expected_seconds(double work) const;

  /// Refuses new jobs, lets accepted ones finish for up to `grace`, then refuses those that wait
  /// (ShuttingDown), trips the stop token of those that run, and joins the workers. Safe to repeat.
  void drain(std::chrono::milliseconds grace);

  std::size_t queued() const;
  std::size_t running() const;
  std::size_t workers() const { return options_.workers; }
  std::uint64_t ended() const;           ///< accepted jobs that are over
  std::uint64_t reserved_bytes() const;  ///< sum of JobCost::bytes of accepted jobs

  /// Whether its own threads still turn: false when every worker is held by a job that does not end although
  /// it should have, or the housekeeper stands still. Never waits.
  bool healthy() const;
  unsigned stuck_workers() const { return stuck_workers_; }

 private:
  using Clock = RunControl::Clock;
  using Seconds = std::chrono::duration<double>;
  using JobPtr = std::shared_ptr<JobHandle::Job>;
  friend class JobHandle;

  Result<> admit(const JobCost& cost, std::optional<Clock::time_point> deadline, const Turn& turn, bool kept);
  Result<> admit_to_queue(const JobCost& cost, const Turn& turn);
  Result<> admit_to_memory(const JobCost& cost, bool kept);
  Seconds expected(const JobPtr& job) const;
  Seconds running_seconds() const;
  Seconds backlog() const;
  Seconds expected_wait(const Turn& turn) const;
  std::chrono::milliseconds next_retry();
  void work();
  void run_one(std::unique_lock<std::mutex>& lock, const JobPtr& job);
  void keep_house();
  void cancel(const JobPtr& job);
  bool take_out(const JobPtr& job);
  void refuse(std::unique_lock<std::mutex>& lock, const std::vector<JobPtr>& jobs, const Error& error);
  void wait_for_jobs(std::unique_lock<std::mutex>& lock);
  void release(const JobPtr& job);

  const JobRunnerOptions options_;     ///< workers resolved to at least one
  std::atomic<Clock::rep> last_tick_;  ///< of the housekeeper
  std::atomic<unsigned> stuck_workers_ = 0;
  mutable std::mutex mutex_;  ///< guards everything below and the state of every Job
  std::condition_variable job_waits_, queue_changed_, job_ended_;
  FairLine<JobPtr> queue_;
  std::size_t kept_waiting_ = 0;  ///< of them
  std::vector<JobPtr> running_;
  std::uint64_t reserved_ = 0;
  std::uint64_t claimed_ = 0;  ///< memory that a kept job waits for
  Clock::time_point claimed_until_ = {};
  Pace pace_;
  RetryTimes retry_times_;
  std::uint64_t ended_ = 0;
  std::size_t pending_ = 0;                       ///< accepted jobs whose callback has not returned yet
  std::optional<Clock::time_point> drain_until_;  ///< set: no new jobs
  bool stopping_ = false;                         ///< threads leave
  std::mutex join_mutex_;                         ///< one drain() joins, others wait for it
  std::vector<std::jthread> threads_;             ///< last: they use all of the above
};

}  // namespace burnish
