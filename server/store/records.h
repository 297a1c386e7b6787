// What the server remembers of jobs, uploads and meshes across its ends. One interface, so that another store
// can follow; sqlite_records.h is the one there is.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "burnish/v1/jobs.pb.h"
#include "core/run/error.h"

namespace burnish {

using WallTime = std::chrono::system_clock::time_point;

/// A job as it is kept. `job` holds all that its caller may see but `progress`.
struct JobRecord {
  v1::Job job = {};
  std::int64_t sequence = 0;   ///< order of acceptance, given by add()
  std::string owner = {};      ///< whose it is; "" when the server asks for no tokens
  std::string transport = {};  ///< "grpc" or "http", for the log and the metrics
  std::string trace_id = {};
  std::string idempotency_key = {};  ///< "": none
  std::string request_hash = {};     ///< SHA-256 of meshes and options
  WallTime expires =
      WallTime::max();  ///< of a job that has ended: from when on it is EXPIRED, then forgotten
};

/// An upload as it is kept.
struct UploadRecord {
  v1::Upload upload = {};
  std::string owner = {};
  WallTime expires = {};
};

/// A mesh that an owner has uploaded or used: jobs of this owner may name it by its SHA-256.
struct MeshRecord {
  std::string owner = {};
  std::string sha256 = {};
  WallTime expires = {};
};

/// Thread-safe; blocks on the disk. What returned without error is there after any end of the server. Errors
/// of all: StorageFull when the disk is full, Internal otherwise.
class Records {
 public:
  virtual ~Records() = default;

  /// A new job, with its meshes remembered for its owner; sets the sequence.
  virtual Result<> add(JobRecord& record, WallTime meshes_expire) = 0;
  virtual Result<> update(const JobRecord& record) = 0;
  virtual Result<> remove_job(const std::string& id) = 0;
  virtual Result<std::optional<JobRecord>> find_job(const std::string& id) = 0;
  virtual Result<std::optional<JobRecord>> find_by_key(const std::string& owner, const std::string& key) = 0;
  /// Of this owner, newest first, those before `sequence`.
  virtual Result<std::vector<JobRecord>> list(const std::string& owner, std::int64_t before,
                                              std::uint32_t limit) = 0;
  /// The last that SUCCEEDED of those that asked for the same.
  virtual Result<std::optional<JobRecord>> find_result(const std::string& owner,
                                                       const std::string& request_hash) = 0;
  /// QUEUED and RUNNING, oldest first.
  virtual Result<std::vector<JobRecord>> unfinished() = 0;
  /// Ended ones whose time is over, oldest first.
  virtual Result<std::vector<JobRecord>> expired(WallTime now, std::uint32_t limit) = 0;

  virtual Result<> put(const UploadRecord& record) = 0;
  virtual Result<> remove_upload(const std::string& id) = 0;
  virtual Result<std::vector<UploadRecord>> uploads() = 0;

  virtual Result<> put(const MeshRecord& record) = 0;
  virtual Result<bool> has_mesh(const std::string& owner, const std::string& sha256) = 0;
  virtual Result<> remove_expired_meshes(WallTime now) = 0;

  /// SHA-256 of every file that a job, an owner's mesh or a result needs.
  virtual Result<std::set<std::string>> files_in_use() = 0;
};

}  // namespace burnish
