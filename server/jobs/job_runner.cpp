#include "server/jobs/job_runner.h"

#include <algorithm>
#include <exception>
#include <utility>

#include <spdlog/spdlog.h>

namespace burnish {
namespace {

constexpr auto kNever = RunControl::Clock::time_point::max();

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
  RunControl::Clock::time_point deadline = kNever;
  RunControl::Clock::time_point queued_at = {};
  std::stop_source stop = {};
};

void JobHandle::cancel() { runner_->cancel(job_); }

JobRunner::JobRunner(const JobRunnerOptions& options) : options_(with_workers(options)) {
  for (unsigned i = 0; i < options_.workers; ++i) threads_.emplace_back([this] { work(); });
  threads_.emplace_back([this] { watch_deadlines(); });
}

JobRunner::~JobRunner() { drain(std::chrono::milliseconds::zero()); }

Result<JobHandle> JobRunner::submit(JobWork work, std::optional<Clock::time_point> deadline) {
  auto job = std::make_shared<JobHandle::Job>();
  job->work = std::move(work);
  job->deadline = deadline.value_or(kNever);
  job->queued_at = Clock::now();

  const std::lock_guard lock(mutex_);
  if (drain_until_) return Error{Cause::ShuttingDown, "the server is shutting down"};
  const std::size_t places = options_.queue + options_.workers - running_.size();
  if (queue_.size() >= places) {
    return Error{Cause::QueueFull,
                 "every worker is busy and " + std::to_string(queue_.size()) + " jobs wait; try again later"};
  }
  queue_.push_back(job);
  ++pending_;
  job_waits_.notify_one();
  if (job->deadline != kNever) queue_changed_.notify_one();
  return JobHandle(std::move(job), this);
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
  RunControl run;
  run.stop = job->stop.get_token();
  if (job->deadline != kNever) run.deadline = job->deadline;
  run.threads = running_.empty() && queue_.empty() ? options_.threads : 1;
  running_.push_back(job);
  lock.unlock();

  const std::chrono::duration<double, std::milli> queued = Clock::now() - job->queued_at;
  call_guarded([&] { job->work.run(run, queued.count()); });

  lock.lock();
  std::erase(running_, job);
  lock.unlock();
  job->work = {};  // what the job held (a mesh) must not live as long as the last handle
  lock.lock();
  --pending_;
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
  pending_ -= jobs.size();
  job_ended_.notify_all();
}

void JobRunner::cancel(const JobPtr& job) {
  job->stop.request_stop();
  std::unique_lock lock(mutex_);
  refuse(lock, {job}, {Cause::Cancelled, "the caller cancelled the job"});
}

void JobRunner::watch_deadlines() {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    const auto now = Clock::now();
    auto next = kNever;
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
    } else if (next == kNever) {
      queue_changed_.wait(lock);
    } else {
      queue_changed_.wait_until(lock, next);
    }
  }
}

}  // namespace burnish
