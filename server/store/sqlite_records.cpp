#include "server/store/sqlite_records.h"

#include <mutex>
#include <utility>

#include "server/store/reserve.h"
#include "server/store/sqlite.h"

namespace burnish {
namespace {

using std::chrono::milliseconds;

constexpr std::int64_t kVersion = 1;
/// Room for what the log grows to between two checkpoints, twice.
constexpr std::uint64_t kReserve = std::uint64_t{1} << 20;
constexpr const char* kCheckpoint = "PRAGMA wal_autocheckpoint = 100";  // pages of 4 KiB
/// `job` and `upload` are the contract's messages; the columns beside them are what is searched for.
constexpr const char* kSchema = R"(
  CREATE TABLE jobs (
    sequence INTEGER PRIMARY KEY AUTOINCREMENT, id TEXT NOT NULL UNIQUE, owner TEXT NOT NULL,
    state INTEGER NOT NULL, expires INTEGER NOT NULL, idempotency_key TEXT NOT NULL, request_hash TEXT NOT NULL,
    transport TEXT NOT NULL, trace_id TEXT NOT NULL, mesh TEXT NOT NULL, reference TEXT NOT NULL,
    result TEXT NOT NULL, job BLOB NOT NULL) STRICT;
  CREATE INDEX jobs_of_owner ON jobs(owner, sequence);
  CREATE INDEX jobs_by_state ON jobs(state, expires);
  CREATE INDEX jobs_by_request ON jobs(owner, request_hash, sequence);
  CREATE UNIQUE INDEX jobs_by_key ON jobs(owner, idempotency_key) WHERE idempotency_key != '';
  CREATE TABLE uploads (
    id TEXT PRIMARY KEY, owner TEXT NOT NULL, expires INTEGER NOT NULL, upload BLOB NOT NULL) STRICT;
  CREATE TABLE meshes (
    owner TEXT NOT NULL, sha256 TEXT NOT NULL, expires INTEGER NOT NULL,
    PRIMARY KEY (owner, sha256)) STRICT, WITHOUT ROWID;
  PRAGMA user_version = 1;
)";
constexpr std::string_view kColumns =
    "sequence, owner, expires, idempotency_key, request_hash, transport, trace_id, job";

std::int64_t to_number(WallTime time) {
  return std::chrono::duration_cast<milliseconds>(time.time_since_epoch()).count();
}
WallTime to_time(std::int64_t number) {
  return WallTime(std::chrono::duration_cast<WallTime::duration>(milliseconds(number)));
}

Result<JobRecord> job_of(const SqliteStatement& row) {
  JobRecord record{.sequence = row.number(0),
                   .owner = row.text(1),
                   .transport = row.text(5),
                   .trace_id = row.text(6),
                   .idempotency_key = row.text(3),
                   .request_hash = row.text(4),
                   .expires = to_time(row.number(2))};
  if (!record.job.ParseFromString(row.text(7)))
    return Error{Cause::Internal, "a job's record cannot be read"};
  return record;
}

/// Everything in it happens, or nothing: unless committed it is undone.
class Transaction {
 public:
  explicit Transaction(sqlite3* database) : database_(database) {
    sqlite3_exec(database, "BEGIN IMMEDIATE", nullptr, nullptr, nullptr);
  }
  ~Transaction() {
    if (!sqlite3_get_autocommit(database_)) sqlite3_exec(database_, "ROLLBACK", nullptr, nullptr, nullptr);
  }
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;

  Result<> commit() { return SqliteStatement(database_, "COMMIT").run(); }

 private:
  sqlite3* database_;
};

class SqliteRecords final : public Records {
 public:
  SqliteRecords(SqliteDatabase database, const std::string& path)
      : reserve_(path + "-reserve", kReserve), database_(std::move(database)) {}

  Result<> add(JobRecord& record, WallTime meshes_expire) override {
    const std::lock_guard lock(mutex_);
    Transaction transaction(database_.get());
    if (auto written = insert(record); !written) return written;
    const std::int64_t sequence = sqlite3_last_insert_rowid(database_.get());
    for (const v1::MeshFile* const mesh : {&record.job.mesh(), &record.job.reference()}) {
      if (mesh->sha256().empty()) continue;
      if (auto kept = remember(record.owner, mesh->sha256(), meshes_expire); !kept) return kept;
    }
    auto committed = transaction.commit();
    if (committed) record.sequence = sequence;
    return committed;
  }

  Result<> update(const JobRecord& record) override {
    const std::lock_guard lock(mutex_);
    const std::string job = record.job.SerializeAsString();
    return also_on_a_full_disk([&] {
      return statement("UPDATE jobs SET state = ?, expires = ?, result = ?, job = ? WHERE id = ?")
          .bind(record.job.state())
          .bind(to_number(record.expires))
          .bind(record.job.result().sha256())
          .bind_bytes(job)
          .bind(record.job.id())
          .run();
    });
  }

  Result<> remove_job(const std::string& id) override {
    const std::lock_guard lock(mutex_);
    return also_on_a_full_disk([&] { return statement("DELETE FROM jobs WHERE id = ?").bind(id).run(); });
  }

  Result<std::optional<JobRecord>> find_job(const std::string& id) override {
    const std::lock_guard lock(mutex_);
    return one(statement(select("WHERE id = ?")).bind(id));
  }

  Result<std::optional<JobRecord>> find_by_key(const std::string& owner, const std::string& key) override {
    const std::lock_guard lock(mutex_);
    return one(statement(select("WHERE owner = ? AND idempotency_key = ? AND idempotency_key != ''"))
                   .bind(owner)
                   .bind(key));
  }

  Result<std::optional<JobRecord>> find_result(const std::string& owner,
                                               const std::string& request_hash) override {
    const std::lock_guard lock(mutex_);
    return one(
        statement(select("WHERE owner = ? AND request_hash = ? AND state = ? ORDER BY sequence DESC LIMIT 1"))
            .bind(owner)
            .bind(request_hash)
            .bind(v1::JOB_STATE_SUCCEEDED));
  }

  Result<std::vector<JobRecord>> list(const std::string& owner, std::int64_t before,
                                      std::uint32_t limit) override {
    const std::lock_guard lock(mutex_);
    return all(statement(select("WHERE owner = ? AND sequence < ? ORDER BY sequence DESC LIMIT ?"))
                   .bind(owner)
                   .bind(before)
                   .bind(std::int64_t{limit}));
  }

  Result<std::vector<JobRecord>> unfinished() override {
    const std::lock_guard lock(mutex_);
    return all(statement(select("WHERE state IN (?, ?) ORDER BY sequence"))
                   .bind(v1::JOB_STATE_QUEUED)
                   .bind(v1::JOB_STATE_RUNNING));
  }

  Result<std::vector<JobRecord>> expired(WallTime now, std::uint32_t limit) override {
    const std::lock_guard lock(mutex_);
    return all(statement(select("WHERE state NOT IN (?, ?) AND expires <= ? ORDER BY expires LIMIT ?"))
                   .bind(v1::JOB_STATE_QUEUED)
                   .bind(v1::JOB_STATE_RUNNING)
                   .bind(to_number(now))
                   .bind(std::int64_t{limit}));
  }

  Result<> put(const UploadRecord& record) override {
    const std::lock_guard lock(mutex_);
    const std::string upload = record.upload.SerializeAsString();
    return statement("INSERT OR REPLACE INTO uploads(id, owner, expires, upload) VALUES (?, ?, ?, ?)")
        .bind(record.upload.id())
        .bind(record.owner)
        .bind(to_number(record.expires))
        .bind_bytes(upload)
        .run();
  }

  Result<> remove_upload(const std::string& id) override {
    const std::lock_guard lock(mutex_);
    return also_on_a_full_disk([&] { return statement("DELETE FROM uploads WHERE id = ?").bind(id).run(); });
  }

  Result<std::vector<UploadRecord>> uploads() override {
    const std::lock_guard lock(mutex_);
    std::vector<UploadRecord> records;
    auto row = statement("SELECT owner, expires, upload FROM uploads");
    for (;;) {
      const auto more = row.step();
      if (!more) return more.error();
      if (!*more) return records;
      UploadRecord record{.owner = row.text(0), .expires = to_time(row.number(1))};
      if (!record.upload.ParseFromString(row.text(2)))
        return Error{Cause::Internal, "an upload's record cannot be read"};
      records.push_back(std::move(record));
    }
  }

  Result<> put(const MeshRecord& record) override {
    const std::lock_guard lock(mutex_);
    return remember(record.owner, record.sha256, record.expires);
  }

  Result<bool> has_mesh(const std::string& owner, const std::string& sha256) override {
    const std::lock_guard lock(mutex_);
    return statement("SELECT 1 FROM meshes WHERE owner = ? AND sha256 = ?").bind(owner).bind(sha256).step();
  }

  Result<> remove_expired_meshes(WallTime now) override {
    const std::lock_guard lock(mutex_);
    auto removed = also_on_a_full_disk(
        [&] { return statement("DELETE FROM meshes WHERE expires <= ?").bind(to_number(now)).run(); });
    reserve_.hold();
    return removed;
  }

  Result<std::set<std::string>> files_in_use() override {
    const std::lock_guard lock(mutex_);
    std::set<std::string> files;
    auto row = statement(
        "SELECT sha256 FROM meshes UNION SELECT result FROM jobs UNION "
        "SELECT mesh FROM jobs WHERE state IN (?1, ?2) UNION "
        "SELECT reference FROM jobs WHERE state IN (?1, ?2)");
    row.bind(v1::JOB_STATE_QUEUED).bind(v1::JOB_STATE_RUNNING);
    for (;;) {
      const auto more = row.step();
      if (!more) return more.error();
      if (!*more) return files;
      files.insert(row.text(0));
    }
  }

 private:
  static std::string select(std::string_view where) {
    return "SELECT " + std::string(kColumns) + " FROM jobs " + std::string(where);
  }
  SqliteStatement statement(std::string_view sql) { return {database_.get(), sql}; }

  /// For writes that end jobs or make room.
  template <class Write>
  Result<> also_on_a_full_disk(const Write& write) {
    auto written = write();
    if (!written && written.error().cause == Cause::StorageFull && reserve_.release()) written = write();
    return written;
  }

  Result<> insert(const JobRecord& record) {
    const std::string job = record.job.SerializeAsString();
    return statement(
               "INSERT INTO jobs(id, owner, state, expires, idempotency_key, request_hash, transport, "
               "trace_id, mesh, reference, result, job) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)")
        .bind(record.job.id())
        .bind(record.owner)
        .bind(record.job.state())
        .bind(to_number(record.expires))
        .bind(record.idempotency_key)
        .bind(record.request_hash)
        .bind(record.transport)
        .bind(record.trace_id)
        .bind(record.job.mesh().sha256())
        .bind(record.job.reference().sha256())
        .bind(record.job.result().sha256())
        .bind_bytes(job)
        .run();
  }

  /// Never for a shorter time than before.
  Result<> remember(const std::string& owner, const std::string& sha256, WallTime expires) {
    return statement(
               "INSERT INTO meshes(owner, sha256, expires) VALUES (?, ?, ?) "
               "ON CONFLICT(owner, sha256) DO UPDATE SET expires = max(expires, excluded.expires)")
        .bind(owner)
        .bind(sha256)
        .bind(to_number(expires))
        .run();
  }

  static Result<std::vector<JobRecord>> all(SqliteStatement& row) {
    std::vector<JobRecord> records;
    for (;;) {
      const auto more = row.step();
      if (!more) return more.error();
      if (!*more) return records;
      auto record = job_of(row);
      if (!record) return std::move(record).error();
      records.push_back(std::move(record).value());
    }
  }

  static Result<std::optional<JobRecord>> one(SqliteStatement& row) {
    auto records = all(row);
    if (!records) return std::move(records).error();
    if (records->empty()) return std::optional<JobRecord>();
    return std::optional(std::move(records->front()));
  }

  std::mutex mutex_;
  Reserve reserve_;
  const SqliteDatabase database_;
};

Result<> set_up(sqlite3* database) {
  for (const char* pragma : {"PRAGMA journal_mode = WAL", "PRAGMA synchronous = FULL", kCheckpoint}) {
    if (auto set = SqliteStatement(database, pragma).run(); !set) return set;
  }
  SqliteStatement version(database, "PRAGMA user_version");
  const auto known = version.step();
  if (!known) return known.error();
  if (version.number(0) == kVersion) return {};
  if (version.number(0) > kVersion) return Error{Cause::BadOption, "a later version of the server made it"};
  Transaction transaction(database);
  if (sqlite3_exec(database, kSchema, nullptr, nullptr, nullptr) != SQLITE_OK) return sqlite_error(database);
  return transaction.commit();
}

}  // namespace

Result<std::unique_ptr<Records>> open_sqlite_records(const std::string& path) {
  sqlite3* opened = nullptr;
  const int code = sqlite3_open_v2(path.c_str(), &opened,
                                   SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX, nullptr);
  SqliteDatabase database(opened);
  auto usable = code == SQLITE_OK ? set_up(database.get()) : Result<>(sqlite_error(database.get()));
  if (!usable)
    return Error{Cause::BadOption,
                 "cannot use the records '" + path + "' (store): " + usable.error().message};
  return std::unique_ptr<Records>(std::make_unique<SqliteRecords>(std::move(database), path));
}

}  // namespace burnish
