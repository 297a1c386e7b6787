// Jobs that outlive their call, the connection and the server. Both transports call this; whatever it answers
// is on disk before.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>

#include "burnish/v1/jobs.pb.h"
#include "server/jobs/fair_line.h"
#include "server/jobs/jobs.h"
#include "server/store/file_store.h"
#include "server/store/records.h"

namespace burnish {

/// A mesh that a submission brings: its bytes, or the SHA-256 of one that its owner has uploaded or used.
struct SubmittedMesh {
  std::string_view bytes = {};
  std::string sha256 = {};
  std::optional<Format> format = {};  ///< unset: told by content

  bool given() const { return !bytes.empty() || !sha256.empty(); }
};

struct Submission {
  SubmittedMesh mesh = {}, reference = {};
  v1::SmoothOptions options = {};
  v1::JobPriority priority = v1::JOB_PRIORITY_NORMAL;
  std::string idempotency_key = {};
  std::optional<std::chrono::milliseconds> timeout = {};  ///< until it must have ended
};

struct DurableJobsOptions {
  std::uint32_t max_jobs = 10'000;                  ///< that have not ended
  std::chrono::seconds max_seconds{7 * 24 * 3600};  ///< of one core that they are expected to take
  std::chrono::seconds keep{24 * 3600};             ///< ended jobs, results, meshes and uploads
  std::uint32_t most_starts = 5;                    ///< of a job, before it is taken for what ends the server
};

/// Thread-safe; blocks on the disk, except where said. Its arguments must outlive it, and stop() must have
/// been called before the runner is drained for good.
class DurableJobs {
 public:
  /// Called with the job as it is, and on each change; the last one has ended. On any thread, one at a time;
  /// must not block, and must not call back.
  using Watcher = std::function<void(const v1::Job& job)>;

  DurableJobs(Records& records, FileStore& files, Jobs& jobs, const DurableJobsOptions& options);
  ~DurableJobs();

  /// Takes up what a former server left, then runs jobs. Errors: those of Records.
  Result<> start();

  /// Keeps the meshes and the job. Errors: those of SmoothService::check(), NotFound for a SHA-256 that the
  /// owner does not have, QueueFull with a time, DeadlineExceeded for a timeout that the jobs at hand are
  /// expected to pass, StorageFull, IdempotencyKeyReused, IdempotencyKeyBusy, ShuttingDown.
  Result<v1::Job> submit(const Caller& caller, Submission submission);

  /// All of these: NotFound also for a job of another owner, Expired for one whose time is over.
  Result<v1::Job> get(const Caller& caller, const std::string& id);
  Result<v1::ListJobsResponse> list(const Caller& caller, std::uint32_t page_size,
                                    const std::string& page_token);
  Result<v1::Job> cancel(const Caller& caller, const std::string& id);
  Result<> remove(const Caller& caller, const std::string& id);

  struct ResultFile {
    v1::MeshFile file;
    StoredBytes content;
  };
  /// The smoothed mesh. Errors: NotFound, NotReady for a job that has not ended, Expired, and for one that
  /// failed what it failed with.
  Result<ResultFile> result(const Caller& caller, const std::string& id);

  /// Calls the watcher at once, and later until the job has ended or the handle is gone. Errors: NotFound.
  Result<std::shared_ptr<void>> watch(const Caller& caller, const std::string& id, Watcher watcher);

  /// No job starts any more; those that run go on until the runner ends them, and wait for the next server
  /// then. Safe to repeat.
  void stop();

  /// Forgets what is out of time, and the files that nobody needs. Errors: those of Records.
  Result<> sweep(WallTime now = std::chrono::system_clock::now());

  std::size_t waiting() const;                              ///< jobs that are QUEUED
  std::size_t running() const;                              ///< jobs that are RUNNING
  std::uint64_t cache_hits() const { return cache_hits_; }  ///< submissions whose result was there
  std::uint64_t cache_misses() const { return cache_misses_; }
  /// When a caller that waits for a job may look again, by what is queued.
  std::chrono::milliseconds look_again_after() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Entry;
  using EntryPtr = std::shared_ptr<Entry>;
  struct Watching;
  struct Prepared;

  Result<std::string> keep_mesh(const Caller& caller, const SubmittedMesh& mesh, const std::string& sha256,
                                const std::string& field);
  Result<std::string> hash_of(const Caller& caller, const SubmittedMesh& mesh, const std::string& field);
  Result<> check(const Caller& caller, const Submission& submission, const SmoothJob& job) const;
  Result<> check_line(const Caller& caller, const Submission& submission, double seconds) const;
  Result<v1::Job> accept(const Caller& caller, const Submission& submission, const std::string& mesh,
                         const std::string& reference, const std::string& request_hash);
  Result<bool> reuse_result(JobRecord& record);
  void end_now(JobRecord& record, v1::JobState state) const;
  Result<JobRecord> find(const Caller& caller, const std::string& id);
  void dispatch();
  void enqueue(const EntryPtr& entry, bool first);
  void leave_line(const EntryPtr& entry);
  void left_line(const EntryPtr& entry);
  void end_late_jobs();
  void start_next(std::unique_lock<std::mutex>& lock);
  Result<Prepared> prepare(const EntryPtr& entry) const;
  double seconds_before(const Turn& turn) const;
  std::chrono::milliseconds next_end() const;
  void run(const EntryPtr& entry, Prepared prepared);
  void ended(const EntryPtr& entry, Result<SmoothResult> result);
  Result<> keep_result(JobRecord& record, SmoothResult& result);
  void put_back(const EntryPtr& entry, std::chrono::milliseconds delay);
  Result<> close(const EntryPtr& entry, JobRecord closed);
  void tell(const EntryPtr& entry);

  Records& records_;
  FileStore& files_;
  Jobs& jobs_;
  const DurableJobsOptions options_;
  mutable std::mutex mutex_;  ///< guards what follows, and every Entry
  std::condition_variable changed_;
  std::map<std::string, EntryPtr> active_;  ///< by id: those that have not ended
  FairLine<std::string> line_;              ///< ids of those that are QUEUED
  double line_seconds_ = 0;                 ///< of one core that they are expected to take
  std::set<std::pair<Clock::time_point, std::string>> deadlines_;  ///< and ids, of those that have one
  std::size_t in_runner_ = 0;
  Clock::time_point not_before_ = {};                        ///< of the next start
  std::set<std::pair<std::string, std::string>> busy_keys_;  ///< owner and key of requests being received
  bool stopping_ = false;
  std::atomic<std::uint64_t> cache_hits_ = 0, cache_misses_ = 0;
  std::mutex join_mutex_;  ///< one stop() joins, others wait for it
  std::jthread dispatcher_;
};

}  // namespace burnish
