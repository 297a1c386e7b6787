// From a submission to a job on disk.
#include "server/jobs/durable_jobs_entry.h"

#include <spdlog/fmt/fmt.h>

#include "core/smooth/registry.h"

namespace burnish {
namespace {

using std::chrono::milliseconds;

constexpr std::size_t kLongestKey = 128;
constexpr milliseconds kLongestTimeout{std::chrono::hours(24)};
constexpr double kSurely = 0.5;  // a deadline is out of reach when so much of the expected time passes it

std::string seconds_text(double seconds) { return fmt::format("{:.1f} s", seconds); }

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

Result<> DurableJobs::check(const Caller& caller, const Submission& submission, const SmoothJob& job) const {
  if (auto fine = jobs_.service().check(job); !fine) return fine;
  for (const std::uint64_t bytes : {job.mesh.size(), job.reference.size()}) {
    if (bytes > kLargestFile)
      return Error{Cause::TooLarge, "a job's meshes have at most " + std::to_string(kLargestFile) + " bytes"};
  }
  if (submission.timeout && (*submission.timeout < milliseconds(1) || *submission.timeout > kLongestTimeout))
    return Error{Cause::BadOption,
                 "timeout_ms is " + std::to_string(submission.timeout->count()) + ", expected 1 to " +
                     std::to_string(kLongestTimeout.count()),
                 "timeout_ms"};
  // That it cannot run now is no reason to refuse a job that waits; that it never can is one.
  auto fits = jobs_.would_take(caller, job);
  const bool never =
      !fits && (fits.error().cause == Cause::TooLarge || fits.error().cause == Cause::ShuttingDown);
  return never ? fits : Result<>();
}

/// Whether the line takes one more, which is expected to take so many seconds of a core. With the lock.
Result<> DurableJobs::check_line(const Caller& caller, const Submission& submission, double seconds) const {
  if (stopping_) return Error{Cause::ShuttingDown, "the server is shutting down"};
  const auto own = std::ranges::count_if(
      active_, [&](const auto& each) { return each.second->record.owner == caller.owner; });
  if (caller.quota.jobs > 0 && own >= caller.quota.jobs) {
    return Error{.cause = Cause::QuotaExceeded,
                 .message = "the token may have " + std::to_string(caller.quota.jobs) +
                            " jobs that have not ended (jobs)",
                 .retry_after = next_end()};
  }
  if (active_.size() >= options_.max_jobs) {
    return Error{
        .cause = Cause::QueueFull,
        .message = std::to_string(active_.size()) + " jobs have not ended (max-jobs); try again later",
        .retry_after = next_end()};
  }
  const auto most = static_cast<double>(options_.max_seconds.count());
  if (!line_.empty() && line_seconds_ + seconds > most) {
    return Error{.cause = Cause::QueueFull,
                 .message = "the jobs that wait are expected to take " + seconds_text(line_seconds_) +
                            " of one core and this one " + seconds_text(seconds) + ", more than " +
                            seconds_text(most) + " (jobs-seconds); try again later",
                 .retry_after = next_end()};
  }
  if (!submission.timeout) return {};
  const double needed = seconds_before({caller.owner, submission.priority == v1::JOB_PRIORITY_LOW}) + seconds;
  if (std::chrono::duration<double>(kSurely * needed) <= *submission.timeout) return {};
  return Error{Cause::DeadlineExceeded,
               "the jobs at hand and this one are expected to take " + seconds_text(needed) +
                   ", longer than timeout_ms allows",
               "timeout_ms"};
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
  job.set_id(jobs_.new_kept_id());
  job.set_state(v1::JOB_STATE_QUEUED);
  job.set_priority(submission.priority);
  set_time(*job.mutable_create_time(), wall_now());
  *job.mutable_options() = submission.options;

  if (submission.timeout) set_time(*job.mutable_deadline(), wall_now() + *submission.timeout);
  SmoothJob smooth;
  smooth.options = submission.options;
  std::shared_ptr<const void> owners[2];
  const auto describe = [&](const SubmittedMesh& from, const std::string& sha256, v1::MeshFile& file,
                            std::string_view& bytes, std::shared_ptr<const void>& owner) -> Result<> {
    bytes = from.bytes;
    if (bytes.empty()) {
      auto stored = files_.map(sha256);
      if (!stored) return std::move(stored).error();
      bytes = stored->bytes;
      owner = stored->owner;
    }
    file.set_sha256(sha256);
    file.set_bytes(static_cast<std::uint32_t>(bytes.size()));
    if (from.format) file.set_format(to_proto(*from.format));
    return {};
  };
  smooth.format = submission.mesh.format;
  auto known = describe(submission.mesh, mesh, *job.mutable_mesh(), smooth.mesh, owners[0]);
  if (known && submission.reference.given()) {
    smooth.reference_format = submission.reference.format;
    known = describe(submission.reference, reference, *job.mutable_reference(), smooth.reference, owners[1]);
  }
  if (!known) return std::move(known).error();
  if (auto fine = check(caller, submission, smooth); !fine) return std::move(fine).error();
  entry->seconds = jobs_.expected_seconds(smooth).count();
  if (submission.timeout) entry->deadline = Clock::now() + *submission.timeout;
  {
    const std::lock_guard lock(mutex_);
    if (auto place = check_line(caller, submission, entry->seconds); !place) return std::move(place).error();
  }
  const std::uint64_t brought = submission.mesh.bytes.size() + submission.reference.bytes.size();
  const std::uint64_t whole = smooth.mesh.size() + smooth.reference.size();
  if (auto paid = jobs_.charge(caller, brought, whole); !paid) return std::move(paid).error();
  for (const auto& [bytes, sha256] :
       {std::pair(submission.mesh.bytes, &mesh), std::pair(submission.reference.bytes, &reference)}) {
    if (bytes.empty()) continue;
    if (auto kept = files_.put(bytes, *sha256); !kept) return std::move(kept).error();
  }
  const auto reused = reuse_result(record);
  if (!reused) return reused.error();
  if (auto kept = records_.add(record, wall_now() + options_.keep); !kept) return std::move(kept).error();
  if (*reused) return record.job;

  const std::lock_guard lock(mutex_);
  active_[job.id()] = entry;
  enqueue(entry, false);
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
  const WallTime at = wall_now();
  record.job.set_state(state);
  set_time(*record.job.mutable_end_time(), at);
  record.expires = at + options_.keep;
  set_time(*record.job.mutable_expire_time(), record.expires);
}

}  // namespace burnish
