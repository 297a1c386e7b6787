// The kept jobs as their owners ask for them.
#include "server/jobs/durable_jobs_entry.h"

#include <charconv>
#include <limits>

#include <spdlog/spdlog.h>

#include "server/jobs/job_states.h"

namespace burnish {
namespace {

using std::chrono::milliseconds;

constexpr std::uint32_t kStandardPage = 100, kLargestPage = 1000, kSweptAtOnce = 500;
/// An expired job stays known as such for so many times the time that ended ones are kept.
constexpr int kTombstone = 7;

milliseconds look_after(double seconds) {
  const double longest = std::chrono::duration<double>(kLongestLook).count();
  return std::max(kShortestLook,
                  std::chrono::ceil<milliseconds>(std::chrono::duration<double>(std::min(seconds, longest))));
}

Error no_such_job() { return {Cause::NotFound, "there is no such job"}; }

}  // namespace

DurableJobs::DurableJobs(Records& records, FileStore& files, Jobs& jobs, const DurableJobsOptions& options)
    : records_(records), files_(files), jobs_(jobs), options_(options) {}

DurableJobs::~DurableJobs() { stop(); }

Result<> DurableJobs::start() {
  auto left = records_.unfinished();
  if (!left) return std::move(left).error();
  for (JobRecord& record : *left) {
    const auto entry = std::make_shared<Entry>(Entry{.record = std::move(record)});
    v1::Job& job = entry->record.job;
    const std::lock_guard lock(mutex_);
    active_[job.id()] = entry;
    if (job.state() == v1::JOB_STATE_RUNNING && job.starts() >= options_.most_starts) {
      JobRecord closed = entry->record;
      closed.job.set_state(v1::JOB_STATE_FAILED);
      *closed.job.mutable_error() = to_proto(
          {Cause::Internal, "the server ended " + std::to_string(job.starts()) + " times while it ran"});
      if (auto kept = close(entry, std::move(closed)); !kept) return kept;
      continue;
    }
    job.set_state(v1::JOB_STATE_QUEUED);
    if (job.has_deadline()) entry->deadline = Clock::now() + (time_of(job.deadline()) - wall_now());
    const auto prepared = prepare(entry);
    entry->seconds = prepared ? jobs_.expected_seconds(prepared->smooth).count() : 0;
    enqueue(entry, false);
  }
  if (!active_.empty()) spdlog::info("jobs: {} of a former server wait", active_.size());
  dispatcher_ = std::jthread([this] { dispatch(); });
  return {};
}

void DurableJobs::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    changed_.notify_all();
  }
  const std::lock_guard joining(join_mutex_);
  if (dispatcher_.joinable()) dispatcher_.join();
}

// ---- Asking ----

/// The job as it is on disk, of this owner, and not EXPIRED.
Result<JobRecord> DurableJobs::find(const Caller& caller, const std::string& id) {
  auto found = records_.find_job(id);
  if (!found) return std::move(found).error();
  if (!*found || (*found)->owner != caller.owner) return no_such_job();
  if ((*found)->job.state() == v1::JOB_STATE_EXPIRED) {
    return Error{Cause::Expired, "the job ended long ago; its result is gone"};
  }
  return *std::move(found).value();
}

Result<v1::Job> DurableJobs::get(const Caller& caller, const std::string& id) {
  {
    const std::lock_guard lock(mutex_);
    const auto found = active_.find(id);
    if (found != active_.end() && found->second->record.owner == caller.owner) return found->second->seen();
  }
  auto record = find(caller, id);
  if (!record) return std::move(record).error();
  return std::move(record->job);
}

Result<v1::ListJobsResponse> DurableJobs::list(const Caller& caller, std::uint32_t page_size,
                                               const std::string& page_token) {
  if (page_size > kLargestPage)
    return Error{Cause::BadOption, "page_size is at most " + std::to_string(kLargestPage), "page_size"};
  if (page_size == 0) page_size = kStandardPage;
  std::int64_t before = std::numeric_limits<std::int64_t>::max();
  const char* const end = page_token.data() + page_token.size();
  if (!page_token.empty()) {
    const auto [stop, failure] = std::from_chars(page_token.data(), end, before);
    if (failure != std::errc() || stop != end || before < 1)
      return Error{Cause::BadOption, "page_token is not one that a list ended with", "page_token"};
  }
  auto records = records_.list(caller.owner, before, page_size + 1);
  if (!records) return std::move(records).error();
  v1::ListJobsResponse response;
  const bool more = records->size() > page_size;
  if (more) records->resize(page_size);
  const std::lock_guard lock(mutex_);
  for (JobRecord& record : *records) {
    const auto active = active_.find(record.job.id());
    v1::Job& job = *response.add_jobs();
    job = active == active_.end() ? std::move(record.job) : active->second->seen();
    job.clear_report();
  }
  if (more) response.set_next_page_token(std::to_string(records->back().sequence));
  return response;
}

Result<DurableJobs::ResultFile> DurableJobs::result(const Caller& caller, const std::string& id) {
  const auto job = get(caller, id);
  if (!job) return job.error();
  if (!has_ended(job->state())) {
    return Error{.cause = Cause::NotReady,
                 .message = "the job has not ended: " + v1::JobState_Name(job->state()),
                 .retry_after = look_again_after()};
  }
  if (job->state() != v1::JOB_STATE_SUCCEEDED) {
    return Error{Cause::NotReady, "the job has no result: " + v1::JobState_Name(job->state()) + ", " +
                                      job->error().code() + ": " + job->error().message()};
  }
  auto content = files_.map(job->result().sha256());
  if (!content) return std::move(content).error();
  return ResultFile{job->result(), std::move(content).value()};
}

Result<std::shared_ptr<void>> DurableJobs::watch(const Caller& caller, const std::string& id,
                                                 Watcher watcher) {
  {
    const std::lock_guard lock(mutex_);
    const auto found = active_.find(id);
    if (found != active_.end() && found->second->record.owner == caller.owner) {
      const auto watching = std::make_shared<Watching>(*this, found->second);
      watcher(found->second->seen());
      found->second->watchers[watching.get()] = std::move(watcher);
      return std::shared_ptr<void>(watching);
    }
  }
  const auto job = get(caller, id);
  if (!job) return job.error();
  watcher(*job);
  return std::shared_ptr<void>();
}

void DurableJobs::tell(const EntryPtr& entry) {
  const v1::Job job = entry->seen();
  for (const auto& [watching, watcher] : entry->watchers) watcher(job);
}

// ---- Ending ----

Result<v1::Job> DurableJobs::cancel(const Caller& caller, const std::string& id) {
  std::optional<JobHandle> handle;
  {
    const std::lock_guard lock(mutex_);
    const auto found = active_.find(id);
    if (found != active_.end() && found->second->record.owner == caller.owner) {
      const EntryPtr entry = found->second;
      JobRecord closed = entry->record;
      closed.job.set_state(v1::JOB_STATE_CANCELLED);
      *closed.job.mutable_error() = to_proto({Cause::Cancelled, "the caller cancelled the job"});
      if (auto kept = close(entry, std::move(closed)); !kept) return std::move(kept).error();
      handle = entry->handle;
    }
  }
  if (handle) handle->cancel();
  return get(caller, id);
}

Result<> DurableJobs::remove(const Caller& caller, const std::string& id) {
  if (auto ended = cancel(caller, id); !ended && ended.error().cause != Cause::Expired) return ended.error();
  return records_.remove_job(id);
}

/// Puts the end of a job on disk, then tells of it. The entry stays as it was when the disk does not take it.
Result<> DurableJobs::close(const EntryPtr& entry, JobRecord closed) {
  end_now(closed, closed.job.state());
  if (auto kept = records_.update(closed); !kept) return kept;
  spdlog::info("job id={} state={} starts={}{}", closed.job.id(), v1::JobState_Name(closed.job.state()),
               closed.job.starts(), closed.job.has_error() ? " code=" + closed.job.error().code() : "");
  entry->record = std::move(closed);
  entry->over = true;
  leave_line(entry);
  active_.erase(entry->record.job.id());
  tell(entry);
  return {};
}

// ---- Housekeeping ----

Result<> DurableJobs::sweep(WallTime at) {
  auto old = records_.expired(at, kSweptAtOnce);
  if (!old) return std::move(old).error();
  for (JobRecord& record : *old) {
    if (record.job.state() == v1::JOB_STATE_EXPIRED) {
      if (auto gone = records_.remove_job(record.job.id()); !gone) return gone;
      continue;
    }
    record.job.set_state(v1::JOB_STATE_EXPIRED);
    record.job.clear_report();
    record.job.clear_result();
    record.expires = at + kTombstone * options_.keep;
    if (auto kept = records_.update(record); !kept) return kept;
  }
  if (auto gone = records_.remove_expired_meshes(at); !gone) return gone;
  return files_.sweep([this] { return records_.files_in_use(); });
}

std::size_t DurableJobs::waiting() const {
  const std::lock_guard lock(mutex_);
  return line_.size();
}

std::size_t DurableJobs::running() const {
  const std::lock_guard lock(mutex_);
  return active_.size() - line_.size();
}

milliseconds DurableJobs::look_again_after() const {
  const std::lock_guard lock(mutex_);
  return look_after(line_seconds_ / static_cast<double>(jobs_.workers()));
}

/// When one job will have ended, as far as is known.
milliseconds DurableJobs::next_end() const {
  const auto size = static_cast<double>(std::max<std::size_t>(1, line_.size()));
  return look_after(line_seconds_ / size / static_cast<double>(jobs_.workers()));
}

/// Until a job that comes now has its turn.
double DurableJobs::seconds_before(const Turn& turn) const {
  double seconds = 0;
  line_.for_each_before(turn, [&](const std::string& id) { seconds += active_.at(id)->seconds; });
  return seconds / static_cast<double>(jobs_.workers());
}

}  // namespace burnish
