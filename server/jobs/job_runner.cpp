#include "server/jobs/job_runner.h"

#include <algorithm>
#include <cstdint>
#include <exception>
#include <string>
#include <utility>

#include <spdlog/spdlog.h>

namespace burnish {

using namespace std::chrono_literals;
using std::chrono::milliseconds;

namespace {

constexpr auto kNever = RunControl::Clock::time_point::max();
constexpr std::chrono::milliseconds kTick{500};   // of the housekeeper
constexpr std::chrono::seconds kMissedTicks{10};  // after which it counts as standing still
/// A deadline is out of reach when so much of the expected time alone passes it: the estimate may be wrong,
/// and a refusal must not be.
constexpr double kSurely = 0.5;
constexpr std::chrono::seconds kClaim{1};  // of memory by a kept job; it asks again sooner

JobRunnerOptions with_workers(JobRunnerOptions options) {
  if (options.workers == 0) options.workers = std::max(1u, std::thread::hardware_concurrency());
  return options;
}

/// A job's callback must not take a worker with it.
template <class Callback>
void call_guarded(Callback&& callback) noexcept {
  try {
    callback();
  } catch (const std::exception& e) {
    spdlog::error("a job's callback threw: {}", e.what());
  } catch (...) {
    spdlog::error("a job's callback threw");
  }
}

Error deadline_while_queued() {
  return {Cause::DeadlineExceeded, "the deadline passed while the job was queued"};
}

}  // namespace

struct JobHandle::Job {
  JobWork work;
  Turn turn;  ///< copies: `work` goes before the lock is taken
  bool kept = false;
  JobCost cost;
  RunControl::Clock::time_point deadline = kNever;
  RunControl::Clock::time_point queued_at = {};
  RunControl::Clock::time_point started_at = {};
  RunControl::Clock::time_point overdue_from = kNever;  ///< when it should have ended
  std::stop_source stop = {};
};

void JobHandle::cancel() { runner_->cancel(job_); }

JobRunner::JobRunner(const JobRunnerOptions& options)
    : options_(with_workers(options)), last_tick_(Clock::now().time_since_epoch().count()) {
  for (unsigned i = 0; i < options_.workers; ++i) threads_.emplace_back([this] { work(); });
  threads_.emplace_back([this] { keep_house(); });
}

JobRunner::~JobRunner() { drain(std::chrono::milliseconds::zero()); }

Result<JobHandle> JobRunner::submit(JobWork work, const JobCost& cost,
                                    std::optional<Clock::time_point> deadline) {
  auto job = std::make_shared<JobHandle::Job>();
  job->turn = work.turn;
  job->kept = work.kept;
  job->work = std::move(work);
  job->cost = cost;
  job->deadline = deadline.value_or(kNever);
  job->queued_at = Clock::now();

  const std::lock_guard lock(mutex_);
  const auto admitted = admit(cost, deadline, job->turn, job->kept);
  if (!admitted) return admitted.error();
  if (job->kept) {
    ++kept_waiting_;
    claimed_ = 0;
  }
  queue_.push_back(job->turn, job);
  reserved_ += cost.bytes;
  ++pending_;
  retry_times_.count_taken();
  job_waits_.notify_one();
  if (job->deadline != kNever) queue_changed_.notify_one();
  return JobHandle(std::move(job), this);
}

Result<> JobRunner::would_take(const JobCost& cost, std::optional<Clock::time_point> deadline,
                               const Turn& turn, bool kept) {
  const std::lock_guard lock(mutex_);
  return admit(cost, deadline, turn, kept);
}

Result<> JobRunner::admit(const JobCost& cost, std::optional<Clock::time_point> deadline, const Turn& turn,
                          bool kept) {
  if (drain_until_) return Error{Cause::ShuttingDown, "the server is shutting down"};
  if (cost.bytes > options_.max_memory) {
    return Error{
        Cause::TooLarge,
        fmt::format("the request is expected to need {} bytes of memory; the limit is {} (max-memory)",
                    cost.bytes, options_.max_memory)};
  }
  if (!kept) {
    if (auto place = admit_to_queue(cost, turn); !place) return place;
  }
  if (auto room = admit_to_memory(cost, kept); !room) return room;
  const auto own = pace_.expect(cost.work);
  const Seconds needed = expected_wait(turn) + own.value_or(Seconds::zero());
  if (deadline && own &&
      Clock::now() + std::chrono::duration_cast<Clock::duration>(kSurely * needed) > *deadline) {
    return Error{Cause::DeadlineExceeded,
                 fmt::format("the jobs at hand and this one are expected to take {:.1f} s, longer than the "
                             "deadline allows",
                             needed.count())};
  }
  return {};
}

/// By count, by share and by time.
Result<> JobRunner::admit_to_queue(const JobCost& cost, const Turn& turn) {
  const std::size_t waiting = queue_.size() - kept_waiting_;
  const std::size_t places = options_.queue + options_.workers - running_.size();
  if (waiting >= places) {
    return Error{Cause::QueueFull,
                 fmt::format("every worker is busy and {} jobs wait (queue); try again later", waiting), "",
                 next_retry()};
  }
  // Dynamic thresholds (Choudhury and Hahne 1998): nobody can take all places, and nobody's are held free.
  if (const std::size_t own = queue_.size_of(turn.owner); !turn.owner.empty() && own >= places - waiting) {
    return Error{
        Cause::QueueFull,
        fmt::format("{} jobs of this caller wait, as many as there are places left for others (queue); "
                    "try again later",
                    own),
        "", next_retry()};
  }
  const Seconds before = backlog();
  if (options_.queue_seconds > 0s && running_.size() + waiting >= options_.workers &&
      before + pace_.expect(cost.work).value_or(Seconds::zero()) > options_.queue_seconds) {
    return Error{
        Cause::QueueFull,
        fmt::format("the jobs at hand are expected to take {:.0f} s (queue-seconds); try again later",
                    before.count()),
        "", next_retry()};
  }
  return {};
}

Result<> JobRunner::admit_to_memory(const JobCost& cost, bool kept) {
  const std::uint64_t claimed = kept || Clock::now() > claimed_until_ ? 0 : claimed_;
  if (reserved_ + claimed <= options_.max_memory - cost.bytes) return {};
  if (kept) {
    claimed_ = cost.bytes;
    claimed_until_ = Clock::now() + kClaim;
  }
  return Error{
      Cause::MemoryFull,
      fmt::format("the jobs at hand need {} of {} bytes (max-memory) and this one {}; try again later",
                  reserved_ + claimed, options_.max_memory, cost.bytes),
      "", kept ? milliseconds::zero() : next_retry()};  // a kept job asks every moment anyway
}

std::chrono::duration<double> JobRunner::expected_seconds(double work) const {
  const std::lock_guard lock(mutex_);
  return pace_.expect(work).value_or(Seconds(work));
}

JobRunner::Seconds JobRunner::expected(const JobPtr& job) const {
  return pace_.expect(job->cost.work).value_or(1s);
}

/// That those that run will still take.
JobRunner::Seconds JobRunner::running_seconds() const {
  const auto now = Clock::now();
  Seconds sum{};
  for (const JobPtr& job : running_)
    sum += std::max(Seconds::zero(), expected(job) - Seconds(now - job->started_at));
  return sum;
}

JobRunner::Seconds JobRunner::backlog() const {
  Seconds sum = running_seconds();
  queue_.for_each([&](const JobPtr& job) { sum += expected(job); });
  return sum;
}

/// Until a worker is free for one more job of this owner.
JobRunner::Seconds JobRunner::expected_wait(const Turn& turn) const {
  if (running_.size() + queue_.size() < options_.workers) return Seconds::zero();
  Seconds sum = running_seconds();
  queue_.for_each_before(turn, [&](const JobPtr& job) { sum += expected(job); });
  return sum / options_.workers;
}

milliseconds JobRunner::next_retry() {
  return retry_times_.next(Clock::now(), backlog() / options_.workers, queue_.size() + running_.size());
}

void JobRunner::drain(std::chrono::milliseconds grace) {
  {
    std::unique_lock lock(mutex_);
    // A later call may shorten the grace period of one that is under way, never lengthen it.
    drain_until_ = std::min(drain_until_.value_or(kNever), Clock::now() + grace);
    job_ended_.notify_all();
    wait_for_jobs(lock);
    stopping_ = true;
  }
  job_waits_.notify_all();
  queue_changed_.notify_all();
  const std::lock_guard joining(join_mutex_);
  threads_.clear();
}

void JobRunner::wait_for_jobs(std::unique_lock<std::mutex>& lock) {
  while (pending_ > 0 && Clock::now() < *drain_until_) {
    const auto until = *drain_until_;
    job_ended_.wait_until(lock, until);
  }
  for (const JobPtr& job : running_) job->stop.request_stop();
  std::vector<JobPtr> waiting;
  while (auto job = queue_.pop()) waiting.push_back(*std::move(job));
  kept_waiting_ = 0;
  refuse(lock, waiting, {Cause::ShuttingDown, "the server shut down before the job could start"});
  job_ended_.wait(lock, [this] { return pending_ == 0; });
}

std::size_t JobRunner::queued() const {
  const std::lock_guard lock(mutex_);
  return queue_.size();
}

std::size_t JobRunner::running() const {
  const std::lock_guard lock(mutex_);
  return running_.size();
}

std::uint64_t JobRunner::reserved_bytes() const {
  const std::lock_guard lock(mutex_);
  return reserved_;
}

std::uint64_t JobRunner::ended() const {
  const std::lock_guard lock(mutex_);
  return ended_;
}

bool JobRunner::healthy() const {
  const Clock::time_point last_tick{Clock::duration(last_tick_.load())};
  return stuck_workers_ < options_.workers && Clock::now() - last_tick < kMissedTicks;
}

void JobRunner::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    job_waits_.wait(lock, [this] { return stopping_ || !queue_.empty(); });
    if (queue_.empty()) return;
    const JobPtr job = queue_.pop().value();
    if (job->kept) --kept_waiting_;
    if (job->deadline <= Clock::now()) {
      refuse(lock, {job}, deadline_while_queued());
    } else {
      run_one(lock, job);
    }
  }
}

void JobRunner::run_one(std::unique_lock<std::mutex>& lock, const JobPtr& job) {
  job->started_at = Clock::now();
  job->overdue_from = std::min(job->deadline, job->started_at + options_.longest_run);
  RunControl run;
  run.stop = job->stop.get_token();
  run.deadline = job->overdue_from;
  run.threads = running_.empty() && queue_.empty() ? options_.threads : 1;
  running_.push_back(job);
  lock.unlock();

  const std::chrono::duration<double, std::milli> queued = job->started_at - job->queued_at;
  call_guarded([&] { job->work.run(run, queued.count()); });
  const bool stopped = run.stopped();
  job->work = {};  // what the job held (a mesh) must not live as long as the last handle

  lock.lock();
  std::erase(running_, job);
  if (!stopped) pace_.learn(job->cost.work, Clock::now() - job->started_at);
  release(job);
}

/// An accepted job is over.
void JobRunner::release(const JobPtr& job) {
  reserved_ -= job->cost.bytes;
  --pending_;
  ++ended_;
  job_ended_.notify_all();
}

/// Out of the queue; false when it waits no more.
bool JobRunner::take_out(const JobPtr& job) {
  if (!queue_.remove(job->turn, job)) return false;
  if (job->kept) --kept_waiting_;
  return true;
}

/// Refuses jobs that have left the queue, without the lock.
void JobRunner::refuse(std::unique_lock<std::mutex>& lock, const std::vector<JobPtr>& jobs,
                       const Error& error) {
  lock.unlock();
  for (const JobPtr& job : jobs) {
    call_guarded([&] { job->work.refuse(error); });
    job->work = {};
  }
  lock.lock();
  for (const JobPtr& job : jobs) release(job);
}

void JobRunner::cancel(const JobPtr& job) {
  job->stop.request_stop();
  std::unique_lock lock(mutex_);
  job->overdue_from = std::min(job->overdue_from, Clock::now());
  if (take_out(job)) refuse(lock, {job}, {Cause::Cancelled, "the caller cancelled the job"});
}

/// Refuses waiting jobs at their deadlines and watches the workers.
void JobRunner::keep_house() {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    const auto now = Clock::now();
    last_tick_ = now.time_since_epoch().count();
    stuck_workers_ = static_cast<unsigned>(std::ranges::count_if(
        running_,
        [now, overrun = options_.overrun](const JobPtr& job) { return now - overrun > job->overdue_from; }));
    auto next = now + kTick;
    std::vector<JobPtr> expired;
    queue_.for_each([&](const JobPtr& job) {
      if (job->deadline <= now) {
        expired.push_back(job);
      } else {
        next = std::min(next, job->deadline);
      }
    });
    for (const JobPtr& job : expired) take_out(job);
    if (!expired.empty()) {
      refuse(lock, expired, deadline_while_queued());
    } else {
      queue_changed_.wait_until(lock, next);
    }
  }
}

}  // namespace burnish
