// Meshes that come in pieces, over as many connections as it takes.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include "burnish/v1/jobs.pb.h"
#include "server/jobs/jobs.h"
#include "server/store/file_store.h"
#include "server/store/records.h"

namespace burnish {

struct UploadsOptions {
  std::chrono::seconds keep{24 * 3600};  ///< after the last bytes
  std::uint32_t most_per_owner = 1000;
};

/// Thread-safe; blocks on the disk.
class Uploads {
 public:
  Uploads(Records& records, FileStore& files, const Jobs& jobs, const UploadsOptions& options = {});

  /// Takes up what a former server left. Errors: those of Records.
  Result<> start();

  /// `bytes` 0: not known. Complete at once when the owner has a mesh of this SHA-256. Errors: TooLarge,
  /// BadOption, QuotaExceeded, StorageFull.
  Result<v1::Upload> create(const Caller& caller, std::uint64_t bytes, const std::string& sha256);
  /// NotFound also for an upload of another owner.
  Result<v1::Upload> get(const Caller& caller, const std::string& id);
  Result<> remove(const Caller& caller, const std::string& id);

  /// Bytes as they come; what was appended is kept when the connection breaks. One at a time for an upload:
  /// every call of one that lost its upload to a later append or to remove() is NotReady.
  class Append {
   public:
    virtual ~Append() = default;  ///< keeps what came
    /// Errors: TooLarge for more than was announced or than the limit, StorageFull.
    virtual Result<> write(std::string_view bytes) = 0;
    /// The caller has sent all of this append; `last`: and all of the mesh. Errors: UploadCorrupt,
    /// BadRequest when it ends before the size that was announced, StorageFull.
    virtual Result<v1::Upload> finish(bool last) = 0;
  };
  /// Takes the upload from an append that is under way. Errors: NotFound, UploadOffsetMismatch (also for an
  /// upload that is complete), StorageFull.
  Result<std::unique_ptr<Append>> append(const Caller& caller, const std::string& id, std::uint64_t offset);

  /// Forgets what is out of time.
  void sweep(WallTime now = std::chrono::system_clock::now());

 private:
  struct Entry;
  using EntryPtr = std::shared_ptr<Entry>;
  class OpenAppend;
  struct Turn;

  Result<EntryPtr> find(const Caller& caller, const std::string& id);
  Result<Turn> turn_at(const Caller& caller, const std::string& id);
  Result<> save(Entry& entry);
  void forget(const EntryPtr& entry);
  Result<bool> fill_if_known(Entry& entry);
  Result<> complete(const EntryPtr& entry);
  std::uint64_t limit() const;

  Records& records_;
  FileStore& files_;
  const Jobs& jobs_;
  const UploadsOptions options_;
  mutable std::mutex mutex_;                 ///< guards what follows, and every Entry
  std::map<std::string, EntryPtr> uploads_;  ///< by id
};

}  // namespace burnish
