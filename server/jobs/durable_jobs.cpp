#include "server/jobs/durable_jobs.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <utility>

#include <google/protobuf/util/time_util.h>
#include <spdlog/spdlog.h>

#include "core/smooth/registry.h"
#include "server/jobs/job_states.h"
#include "server/observe/log.h"

namespace burnish {
namespace {

using google::protobuf::util::TimeUtil;
using std::chrono::milliseconds;

constexpr std::uint32_t kStandardPage = 100, kLargestPage = 1000, kSweptAtOnce = 500;
constexpr std::uint64_t kLargestFile = std::numeric_limits<std::uint32_t>::max();  // of MeshFile::bytes
constexpr std::size_t kLongestKey = 128;
constexpr milliseconds kShortestLook{1000}, kLongestLook{60'000}, kNoPlace{100}, kDiskFull{10'000};
/// An expired job stays known as such for so many times the time that ended ones are kept.
constexpr int kTombstone = 7;

WallTime now() { return std::chrono::system_clock::now(); }

void set_time(google::protobuf::Timestamp& to, WallTime time) {
  to = TimeUtil::MillisecondsToTimestamp(
      std::chrono::duration_cast<milliseconds>(time.time_since_epoch()).count());
}

Error no_such_job() { return {Cause::NotFound, "there is no such job"}; }

v1::JobError to_proto(const Error& error) {
  v1::JobError proto;
  std::string code(cause_code(error.cause));
  std::ranges::transform(code, code.begin(),
                         [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  proto.set_code(code);
  proto.set_message(error.message);
  proto.set_field(error.field);
  return proto;
}

/// Two requests with the same hash have the same result.
std::string request_hash(const Submission& submission, const std::string& mesh,
                         const std::string& reference) {
  v1::SubmitJobRequest request;
  request.set_mesh_sha256(mesh);
  request.set_reference_sha256(reference);
  request.set_format(submission.mesh.format ? to_proto(*submission.mesh.format)
                                            : v1::MESH_FORMAT_UNSPECIFIED);
  request.set_reference_format(submission.reference.format ? to_proto(*submission.reference.format)
                                                           : v1::MESH_FORMAT_UNSPECIFIED);
  return sha256_of(request.SerializeAsString() + to_json(submission.options, true));  // maps in their order
}

Result<> check_key(const std::string& key) {
  const bool fine =
      key.size() <= kLongestKey && std::ranges::all_of(key, [](char c) { return c > ' ' && c <= '~'; });
  if (fine) return {};
  return Error{Cause::BadOption,
               "the idempotency key has 1 to 128 printable ASCII characters, without spaces",
               "idempotency_key"};
}

/// Frees an idempotency key that its request no longer occupies.
template <class Function>
class Finally {
 public:
  explicit Finally(Function function) : function_(std::move(function)) {}
  ~Finally() { function_(); }
  Finally(const Finally&) = delete;
  Finally& operator=(const Finally&) = delete;

 private:
  Function function_;
};

}  // namespace

/// A job that has not ended.
struct DurableJobs::Entry {
  JobRecord record;
  v1::SmoothProgress progress = {};
  std::optional<JobHandle> handle = {};  ///< while a worker has it or is to have it
  bool over = false;                     ///< its end is on disk: whatever the worker still says is dropped
  std::map<const Watching*, Watcher> watchers = {};
  Clock::time_point started = {};

  v1::Job seen() const {
    v1::Job job = record.job;
    if (job.state() == v1::JOB_STATE_RUNNING) *job.mutable_progress() = progress;
    return job;
  }
};

/// Takes its watcher away when it goes.
struct DurableJobs::Watching {
  Watching(DurableJobs& of, EntryPtr at) : jobs(of), entry(std::move(at)) {}
  ~Watching() {
    const std::lock_guard lock(jobs.mutex_);
    entry->watchers.erase(this);
  }
  Watching(const Watching&) = delete;
  Watching& operator=(const Watching&) = delete;

  DurableJobs& jobs;
  const EntryPtr entry;
};

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
    line_.push_back(job.priority(), entry->record.owner, job.id());
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

// ---- Submitting ----

/// The SHA-256 of the mesh, which is the owner's to use; "" for none.
Result<std::string> DurableJobs::hash_of(const Caller& caller, const SubmittedMesh& mesh,
                                         const std::string& field) {
  if (!mesh.bytes.empty()) return sha256_of(mesh.bytes);
  if (mesh.sha256.empty()) return std::string();
  auto sha256 = parse_sha256(mesh.sha256, field);
  if (!sha256) return sha256;
  const auto known = records_.has_mesh(caller.owner, *sha256);
  if (!known) return known.error();
  if (!*known || !files_.has(*sha256)) {
    return Error{Cause::NotFound, "there is no mesh " + *sha256 + "; upload it first", field};
  }
  return sha256;
}

Result<v1::Job> DurableJobs::submit(const Caller& caller, Submission submission) {
  const auto method = find_method(submission.options.method());
  if (!method) return method.error();
  submission.options.set_method((*method)->name);  // the same request, whether the default is named or not
  if (auto fine = check_key(submission.idempotency_key); !fine) return fine.error();
  if (!submission.mesh.given()) return Error{Cause::EmptyMesh, "the request has no mesh", "mesh"};
  const auto held = files_.hold();
  const auto mesh = hash_of(caller, submission.mesh, "mesh_sha256");
  if (!mesh) return mesh.error();
  const auto reference = hash_of(caller, submission.reference, "reference_sha256");
  if (!reference) return reference.error();
  const std::string hash = request_hash(submission, *mesh, *reference);
  const std::pair key(caller.owner, submission.idempotency_key);
  if (key.second.empty()) return accept(caller, submission, *mesh, *reference, hash);

  {
    const std::lock_guard lock(mutex_);
    if (!busy_keys_.insert(key).second) {
      return Error{.cause = Cause::IdempotencyKeyBusy,
                   .message = "a request with this idempotency key is being received",
                   .retry_after = kShortestLook};
    }
  }
  const Finally free_key([&] {
    const std::lock_guard lock(mutex_);
    busy_keys_.erase(key);
  });
  auto known = records_.find_by_key(caller.owner, submission.idempotency_key);
  if (!known) return std::move(known).error();
  if (!*known) return accept(caller, submission, *mesh, *reference, hash);
  if ((*known)->request_hash == hash) return get(caller, (*known)->job.id());
  return Error{Cause::IdempotencyKeyReused, "the idempotency key came before, with another request",
               "idempotency_key"};
}

Result<> DurableJobs::check(const Caller& caller, const Submission& submission, std::uint64_t mesh_bytes,
                            std::uint64_t reference_bytes) const {
  const SmoothService& service = jobs_.service();
  if (auto fine = service.check(submission.options); !fine) return fine;
  for (const std::uint64_t bytes : {mesh_bytes, reference_bytes}) {
    if (bytes > kLargestFile)
      return Error{Cause::TooLarge, "a job's meshes have at most " + std::to_string(kLargestFile) + " bytes"};
  }
  // That it cannot run now is no reason to refuse a job that waits; that it never can is one.
  auto fits = jobs_.expect(caller, mesh_bytes, reference_bytes);
  const bool never =
      !fits && (fits.error().cause == Cause::TooLarge || fits.error().cause == Cause::ShuttingDown);
  if (never) return fits;
  const std::lock_guard lock(mutex_);
  if (stopping_) return Error{Cause::ShuttingDown, "the server is shutting down"};
  const auto own = std::ranges::count_if(
      active_, [&](const auto& each) { return each.second->record.owner == caller.owner; });
  if (caller.quota.jobs > 0 && own >= caller.quota.jobs) {
    return Error{.cause = Cause::QuotaExceeded,
                 .message = "the token may have " + std::to_string(caller.quota.jobs) +
                            " jobs that have not ended (jobs)",
                 .retry_after = kShortestLook};
  }
  if (active_.size() < options_.max_jobs) return {};
  return Error{.cause = Cause::QueueFull,
               .message = std::to_string(active_.size()) + " jobs have not ended (max-jobs); try again later",
               .retry_after = kLongestLook};
}

Result<v1::Job> DurableJobs::accept(const Caller& caller, const Submission& submission,
                                    const std::string& mesh, const std::string& reference,
                                    const std::string& hash) {
  const auto entry = std::make_shared<Entry>();
  JobRecord& record = entry->record;
  record.owner = caller.owner;
  record.transport = transport_name(caller.transport);
  record.trace_id = caller.trace_id;
  record.idempotency_key = submission.idempotency_key;
  record.request_hash = hash;
  v1::Job& job = record.job;
  job.set_id(new_request_id() + new_request_id());
  job.set_state(v1::JOB_STATE_QUEUED);
  job.set_priority(submission.priority);
  set_time(*job.mutable_create_time(), now());
  *job.mutable_options() = submission.options;

  std::uint64_t sizes[2] = {};
  const std::pair<const SubmittedMesh*, const std::string*> given[] = {{&submission.mesh, &mesh},
                                                                       {&submission.reference, &reference}};
  for (std::size_t i = 0; i < 2; ++i) {
    const auto& [from, sha256] = given[i];
    if (!from->given()) continue;
    sizes[i] = from->bytes.size();
    if (from->bytes.empty()) {
      const auto stored = files_.map(*sha256);
      if (!stored) return stored.error();
      sizes[i] = stored->bytes.size();
    }
    v1::MeshFile& file = i == 0 ? *job.mutable_mesh() : *job.mutable_reference();
    file.set_sha256(*sha256);
    file.set_bytes(static_cast<std::uint32_t>(sizes[i]));
    if (from->format) file.set_format(to_proto(*from->format));
  }
  if (auto fine = check(caller, submission, sizes[0], sizes[1]); !fine) return std::move(fine).error();
  const std::uint64_t brought = submission.mesh.bytes.size() + submission.reference.bytes.size();
  if (auto paid = jobs_.charge(caller, brought, sizes[0] + sizes[1]); !paid) return std::move(paid).error();
  for (const auto& [from, sha256] : given) {
    if (from->bytes.empty()) continue;
    if (auto kept = files_.put(from->bytes, *sha256); !kept) return std::move(kept).error();
  }
  const auto reused = reuse_result(record);
  if (!reused) return reused.error();
  if (auto kept = records_.add(record, now() + options_.keep); !kept) return std::move(kept).error();
  if (*reused) return record.job;

  const std::lock_guard lock(mutex_);
  active_[job.id()] = entry;
  line_.push_back(job.priority(), record.owner, job.id());
  changed_.notify_all();
  return entry->seen();
}

/// Determinism makes it right: the job has SUCCEEDED before it began when the same was asked for before.
Result<bool> DurableJobs::reuse_result(JobRecord& record) {
  const auto earlier = records_.find_result(record.owner, record.request_hash);
  if (!earlier) return earlier.error();
  const bool known = *earlier && (*earlier)->job.report().version() == version() &&
                     files_.has((*earlier)->job.result().sha256());
  ++(known ? cache_hits_ : cache_misses_);
  if (!known) return false;
  v1::Job& job = record.job;
  *job.mutable_result() = (*earlier)->job.result();
  *job.mutable_report() = (*earlier)->job.report();
  job.mutable_report()->set_request_id(job.id());
  job.set_from_cache(true);
  end_now(record, v1::JOB_STATE_SUCCEEDED);
  return true;
}

void DurableJobs::end_now(JobRecord& record, v1::JobState state) const {
  const WallTime at = now();
  record.job.set_state(state);
  set_time(*record.job.mutable_end_time(), at);
  record.expires = at + options_.keep;
  set_time(*record.job.mutable_expire_time(), record.expires);
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
      line_.remove(closed.job.priority(), closed.owner, id);
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
  active_.erase(entry->record.job.id());
  tell(entry);
  return {};
}

// ---- Running ----

void DurableJobs::dispatch() {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    if (line_.size() > 0 && in_runner_ < jobs_.workers()) {
      if (Clock::now() < not_before_) {
        changed_.wait_until(lock, not_before_);
        continue;
      }
      if (start_next(lock)) continue;
    }
    changed_.wait(lock);
  }
}

/// Marks the next job as running and hands it to the workers. False when there is none.
bool DurableJobs::start_next(std::unique_lock<std::mutex>& lock) {
  const auto id = line_.pop();
  if (!id) return false;
  const EntryPtr entry = active_.at(*id);
  const v1::Job& job = entry->record.job;
  const Caller caller{.owner = entry->record.owner};
  const auto fits = jobs_.expect(caller, job.mesh().bytes(), job.reference().bytes());
  const bool passing = !fits && fits.error().cause != Cause::TooLarge;
  JobRecord started = entry->record;
  started.job.set_state(v1::JOB_STATE_RUNNING);
  started.job.set_starts(started.job.starts() + 1);
  set_time(*started.job.mutable_start_time(), now());
  const auto kept = passing ? Result<>() : records_.update(started);
  if (passing || !kept) {
    line_.push_front(job.priority(), entry->record.owner, *id);
    not_before_ = Clock::now() + (passing ? kNoPlace : kDiskFull);
    return true;
  }
  entry->record = std::move(started);
  entry->progress.Clear();
  entry->progress.set_stage(v1::SMOOTH_STAGE_QUEUE);
  entry->started = Clock::now();
  ++in_runner_;
  tell(entry);
  lock.unlock();
  run(entry);
  lock.lock();
  return true;
}

void DurableJobs::run(const EntryPtr& entry) {
  const JobRecord& record = entry->record;
  const v1::Job& job = record.job;
  Caller caller{
      .transport = record.transport == transport_name(Transport::Grpc) ? Transport::Grpc : Transport::Http,
      .request_id = job.id(),
      .trace_id = record.trace_id,
      .owner = record.owner};
  SmoothJob smooth{.mesh = {},
                   .format = from_proto(job.mesh().format()),
                   .reference_format = from_proto(job.reference().format()),
                   .options = job.options()};
  auto mesh = files_.map(job.mesh().sha256());
  if (!mesh) return ended(entry, std::move(mesh).error());
  smooth.mesh = mesh->bytes;
  Result<StoredBytes> reference = StoredBytes();
  if (job.has_reference()) {
    reference = files_.map(job.reference().sha256());
    if (!reference) return ended(entry, std::move(reference).error());
    smooth.reference = reference->bytes;
  }
  smooth.progress = [this, entry](v1::SmoothStage stage, double fraction) {
    const std::lock_guard lock(mutex_);
    if (entry->over) return;
    entry->progress.set_stage(stage);
    entry->progress.set_fraction(fraction);
    tell(entry);
  };
  auto handle = jobs_.smooth(caller, std::move(smooth),
                             [this, entry, kept = std::pair(mesh->owner, reference->owner)](
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
  const double took = std::chrono::duration<double>(Clock::now() - entry->started).count();
  seconds_per_job_ += 0.2 * (took - seconds_per_job_);
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
  line_.push_front(job.priority(), entry->record.owner, job.id());
  not_before_ = Clock::now() + delay;
  changed_.notify_all();
  tell(entry);
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
  const double seconds =
      seconds_per_job_ * static_cast<double>(line_.size() + 1) / static_cast<double>(jobs_.workers());
  return std::clamp(milliseconds(static_cast<std::int64_t>(1000 * seconds)), kShortestLook, kLongestLook);
}

}  // namespace burnish
