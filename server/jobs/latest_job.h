// The latest word on a job, for a thread that waits for it.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "server/jobs/durable_jobs.h"
#include "server/jobs/job_states.h"

namespace burnish {

class LatestJob {
 public:
  /// Watches from now on. Errors: those of DurableJobs::watch().
  static Result<LatestJob> watch(DurableJobs& jobs, const Caller& caller, const std::string& id) {
    LatestJob latest;
    auto handle = jobs.watch(caller, id, [word = latest.word_](const v1::Job& job) {
      const std::lock_guard lock(word->mutex);
      word->job = job;
      ++word->version;
      word->changed.notify_all();
    });
    if (!handle) return std::move(handle).error();
    latest.handle_ = std::move(handle).value();
    return latest;
  }

  /// Waits for a word newer than `seen` (0 at first) for at most `patience`; false when there is none.
  bool wait(std::uint64_t& seen, std::chrono::milliseconds patience, v1::Job& job) const {
    std::unique_lock lock(word_->mutex);
    if (!word_->changed.wait_for(lock, patience, [&] { return word_->version != seen; })) return false;
    seen = word_->version;
    job = word_->job;
    return true;
  }

  /// So that a listener need not hear of every iteration: returns early only when the job has ended.
  void pause(std::chrono::milliseconds time) const {
    std::unique_lock lock(word_->mutex);
    word_->changed.wait_for(lock, time, [this] { return has_ended(word_->job.state()); });
  }

 private:
  /// Shared with the watcher, for either may be gone first.
  struct Word {
    std::mutex mutex;
    std::condition_variable changed;
    v1::Job job;
    std::uint64_t version = 0;
  };

  LatestJob() = default;

  std::shared_ptr<Word> word_ = std::make_shared<Word>();
  std::shared_ptr<void> handle_;
};

}  // namespace burnish
