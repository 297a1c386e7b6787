// From the line to a worker to the end.
#include "server/jobs/durable_jobs_entry.h"

#include <spdlog/spdlog.h>

namespace burnish {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kNoPlace{100}, kDiskFull{10'000};

}  // namespace

/// With the lock, as all that touches the line.
void DurableJobs::enqueue(const EntryPtr& entry, bool first) {
  const std::string& id = entry->record.job.id();
  if (first) {
    line_.push_front(entry->turn(), id);
  } else {
    line_.push_back(entry->turn(), id);
  }
  line_seconds_ += entry->seconds;
  if (entry->deadline) deadlines_.emplace(*entry->deadline, id);
  changed_.notify_all();
}

void DurableJobs::leave_line(const EntryPtr& entry) {
  const std::string& id = entry->record.job.id();
  if (line_.remove(entry->turn(), id)) left_line(entry);
}

void DurableJobs::left_line(const EntryPtr& entry) {
  line_seconds_ = line_.empty() ? 0 : line_seconds_ - entry->seconds;
  if (entry->deadline) deadlines_.erase({*entry->deadline, entry->record.job.id()});
}

void DurableJobs::dispatch() {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    end_late_jobs();
    auto until = deadlines_.empty() ? Clock::time_point::max() : deadlines_.begin()->first;
    if (!line_.empty() && in_runner_ < jobs_.workers()) {
      if (Clock::now() >= not_before_) {
        start_next(lock);
        continue;
      }
      until = std::min(until, not_before_);
    }
    if (until == Clock::time_point::max()) {
      changed_.wait(lock);
    } else {
      changed_.wait_until(lock, until);
    }
  }
}

/// Those that wait although their time is over.
void DurableJobs::end_late_jobs() {
  while (!deadlines_.empty() && deadlines_.begin()->first <= Clock::now()) {
    const EntryPtr entry = active_.at(deadlines_.begin()->second);
    JobRecord closed = entry->record;
    closed.job.set_state(v1::JOB_STATE_FAILED);
    *closed.job.mutable_error() =
        to_proto({Cause::DeadlineExceeded, "the deadline passed while the job was queued"});
    if (auto kept = close(entry, std::move(closed)); kept) continue;
    deadlines_.erase(deadlines_.begin());  // tried again when it is next
    return;
  }
}

/// With the files in memory. Errors: NotFound, OutOfMemory.
Result<DurableJobs::Prepared> DurableJobs::prepare(const EntryPtr& entry) const {
  const JobRecord& record = entry->record;
  const v1::Job& job = record.job;
  Prepared prepared{
      .caller = {.transport =
                     record.transport == transport_name(Transport::Grpc) ? Transport::Grpc : Transport::Http,
                 .request_id = job.id(),
                 .trace_id = record.trace_id,
                 .owner = record.owner,
                 .deadline = entry->deadline,
                 .low = entry->turn().low,
                 .kept = true},
      .smooth = {.mesh = {},
                 .format = from_proto(job.mesh().format()),
                 .reference_format = from_proto(job.reference().format()),
                 .options = job.options()}};
  auto mesh = files_.map(job.mesh().sha256());
  if (!mesh) return std::move(mesh).error();
  prepared.smooth.mesh = mesh->bytes;
  prepared.mesh = mesh->owner;
  if (!job.has_reference()) return prepared;
  auto reference = files_.map(job.reference().sha256());
  if (!reference) return std::move(reference).error();
  prepared.smooth.reference = reference->bytes;
  prepared.reference = reference->owner;
  return prepared;
}

/// Marks the next job as running and hands it to the workers.
void DurableJobs::start_next(std::unique_lock<std::mutex>& lock) {
  const EntryPtr entry = active_.at(line_.pop().value());
  left_line(entry);
  lock.unlock();
  auto prepared = prepare(entry);
  const auto fits = prepared ? jobs_.would_take(prepared->caller, prepared->smooth) : Result<>();
  lock.lock();
  if (entry->over) return;
  const bool passing = !fits && fits.error().cause != Cause::TooLarge;
  JobRecord started = entry->record;
  started.job.set_state(v1::JOB_STATE_RUNNING);
  started.job.set_starts(started.job.starts() + 1);
  set_time(*started.job.mutable_start_time(), wall_now());
  const auto kept = passing ? Result<>() : records_.update(started);
  if (passing || !kept) {
    not_before_ = Clock::now() + (passing ? kNoPlace : kDiskFull);
    return enqueue(entry, true);
  }
  entry->record = std::move(started);
  entry->progress.Clear();
  entry->progress.set_stage(v1::SMOOTH_STAGE_QUEUE);
  entry->started = Clock::now();
  ++in_runner_;
  tell(entry);
  lock.unlock();
  if (prepared) {
    run(entry, std::move(prepared).value());
  } else {
    ended(entry, std::move(prepared).error());
  }
  lock.lock();
}

void DurableJobs::run(const EntryPtr& entry, Prepared prepared) {
  prepared.smooth.progress = [this, entry](v1::SmoothStage stage, double fraction) {
    const std::lock_guard lock(mutex_);
    if (entry->over) return;
    entry->progress.set_stage(stage);
    entry->progress.set_fraction(fraction);
    tell(entry);
  };
  auto handle = jobs_.smooth(prepared.caller, std::move(prepared.smooth),
                             [this, entry, kept = std::pair(prepared.mesh, prepared.reference)](
                                 Result<SmoothResult> result) { ended(entry, std::move(result)); });
  if (!handle) return;
  bool cancelled = false;
  {
    const std::lock_guard lock(mutex_);
    entry->handle = handle;
    cancelled = entry->over;  // while it was being handed over
  }
  if (cancelled) handle->cancel();
}

/// On a worker, or on whichever thread learns that no worker will have it.
void DurableJobs::ended(const EntryPtr& entry, Result<SmoothResult> result) {
  JobRecord closed;
  {
    const std::lock_guard lock(mutex_);
    --in_runner_;
    changed_.notify_all();
    entry->handle.reset();
    if (entry->over) return;
    closed = entry->record;
  }
  if (!result) {
    const Cause cause = result.error().cause;
    if (cause == Cause::ShuttingDown) return put_back(entry, milliseconds::zero());
    if (cause == Cause::QueueFull || cause == Cause::MemoryFull) return put_back(entry, kNoPlace);
  }
  const auto held = files_.hold();
  if (result) {
    if (auto kept = keep_result(closed, *result); !kept) result = std::move(kept).error();
  }
  if (!result) {
    closed.job.set_state(v1::JOB_STATE_FAILED);
    *closed.job.mutable_error() = to_proto(result.error());
  }
  std::unique_lock lock(mutex_);
  if (entry->over) return;
  const auto kept = close(entry, std::move(closed));
  lock.unlock();
  if (!kept) put_back(entry, kDiskFull);
}

Result<> DurableJobs::keep_result(JobRecord& record, SmoothResult& result) {
  if (result.mesh.size() > kLargestFile)
    return Error{Cause::TooLarge, "the result has more than " + std::to_string(kLargestFile) + " bytes"};
  const std::string sha256 = sha256_of(result.mesh);
  if (auto kept = files_.put(result.mesh, sha256); !kept) return kept;
  v1::Job& job = record.job;
  job.set_state(v1::JOB_STATE_SUCCEEDED);
  job.mutable_result()->set_sha256(sha256);
  job.mutable_result()->set_bytes(static_cast<std::uint32_t>(result.mesh.size()));
  job.mutable_result()->set_format(to_proto(result.format));
  job.mutable_report()->Swap(&result.report);
  return {};
}

/// It waits again: for a place, for the disk, or for the next server. A start that the job cannot help does
/// not count.
void DurableJobs::put_back(const EntryPtr& entry, milliseconds delay) {
  const std::lock_guard lock(mutex_);
  if (entry->over) return;
  v1::Job& job = entry->record.job;
  job.set_state(v1::JOB_STATE_QUEUED);
  job.set_starts(job.starts() - 1);
  if (auto kept = records_.update(entry->record); !kept)
    spdlog::error("job id={}: {}", job.id(),
                  kept.error().message);  // on disk it is RUNNING: the same to a next server
  not_before_ = Clock::now() + delay;
  enqueue(entry, true);
  tell(entry);
}

}  // namespace burnish
