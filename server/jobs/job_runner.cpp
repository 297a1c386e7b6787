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
constexpr std::chrono::minutes kFarthestTurn{1};

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
  job->work = std::move(work);
  job->cost = cost;
  job->deadline = deadline.value_or(kNever);
  job->queued_at = Clock::now();

  const std::lock_guard lock(mutex_);
  if (auto admitted = admit(cost, deadline); !admitted) return std::move(admitted).error();
  queue_.push_back(job);
  reserved_ += cost.bytes;
  ++pending_;
  job_waits_.notify_one();
  if (job->deadline != kNever) queue_changed_.notify_one();
  return JobHandle(std::move(job), this);
}

Result<> JobRunner::would_take(const JobCost& cost, std::optional<Clock::time_point> deadline) {
  const std::lock_guard lock(mutex_);
  return admit(cost, deadline);
}

Result<> JobRunner::admit(const JobCost& cost, std::optional<Clock::time_point> deadline) {
  if (drain_until_) return Error{Cause::ShuttingDown, "the server is shutting down"};
  if (cost.bytes > options_.max_memory) {
    return Error{
        Cause::TooLarge,
        fmt::format("the request is expected to need {} bytes of memory; the limit is {} (max-memory)",
                    cost.bytes, options_.max_memory)};
  }
  if (queue_.size() >= options_.queue + options_.workers - running_.size()) {
    return Error{Cause::QueueFull,
                 fmt::format("every worker is busy and {} jobs wait (queue); try again later", queue_.size()),
                 "", next_turn()};
  }
  if (reserved_ > options_.max_memory - cost.bytes) {
    return Error{
        Cause::MemoryFull,
        fmt::format("the jobs at hand need {} of {} bytes (max-memory) and this one {}; try again later",
                    reserved_, options_.max_memory, cost.bytes),
        "", next_turn()};
  }
  const auto own = pace_.expect(cost.work);
  const Seconds needed = expected_wait() + own.value_or(Seconds::zero());
  if (deadline && own &&
      Clock::now() + std::chrono::duration_cast<Clock::duration>(kSurely * needed) > *deadline) {
    return Error{Cause::DeadlineExceeded,
                 fmt::format("the jobs at hand and this one are expected to take {:.1f} s, longer than the "
                             "deadline allows",
                             needed.count())};
  }
  return {};
}

/// Until a worker is free for one more job.
JobRunner::Seconds JobRunner::expected_wait() const {
  if (running_.size() + queue_.size() < options_.workers) return Seconds::zero();
  const auto expected = [this](const JobPtr& job) { return pace_.expect(job->cost.work).value_or(1s); };
  const auto now = Clock::now();
  Seconds sum{};
  for (const JobPtr& job : queue_) sum += expected(job);
  for (const JobPtr& job : running_)
    sum += std::max(Seconds::zero(), expected(job) - Seconds(now - job->started_at));
  return sum / options_.workers;
}

/// When a caller that is refused now may come back. Each is given a turn of its own, behind those refused
/// before: all at once they would be refused again.
milliseconds JobRunner::next_turn() {
  const auto now = Clock::now();
  const Seconds wait = expected_wait();
  const Seconds each = wait / static_cast<double>(std::max<std::size_t>(1, queue_.size() + running_.size()));
  const auto steps = [](Seconds seconds) { return std::chrono::duration_cast<Clock::duration>(seconds); };
  next_turn_ = std::max(next_turn_ + steps(each), now + steps(wait));
  next_turn_ = std::min(next_turn_, now + kFarthestTurn);
  return std::chrono::ceil<milliseconds>(next_turn_ - now);
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
  refuse(lock, {queue_.begin(), queue_.end()},
         {Cause::ShuttingDown, "the server shut down before the job could start"});
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
    const JobPtr job = queue_.front();
    if (job->deadline <= Clock::now()) {
      refuse(lock, {job}, deadline_while_queued());
    } else {
      queue_.pop_front();
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

/// Takes those of `jobs` that still wait out of the queue and refuses them without the lock.
void JobRunner::refuse(std::unique_lock<std::mutex>& lock, std::vector<JobPtr> jobs, const Error& error) {
  std::erase_if(jobs, [this](const JobPtr& job) { return std::erase(queue_, job) == 0; });
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
  refuse(lock, {job}, {Cause::Cancelled, "the caller cancelled the job"});
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
    for (const JobPtr& job : queue_) {
      if (job->deadline <= now) {
        expired.push_back(job);
      } else {
        next = std::min(next, job->deadline);
      }
    }
    if (!expired.empty()) {
      refuse(lock, std::move(expired), deadline_while_queued());
    } else {
      queue_changed_.wait_until(lock, next);
    }
  }
}

}  // namespace burnish
