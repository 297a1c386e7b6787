// Files on the server's disk, named by the SHA-256 of their bytes: each is there whole and for good, or not
// at all, whenever the server ends.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <shared_mutex>
#include <string>
#include <string_view>

#include "core/run/error.h"

namespace burnish {

/// 64 lower case hexadecimal digits.
std::string sha256_of(std::string_view bytes);
/// Digits in either case to those of sha256_of(). Errors: BadOption, naming `field`.
Result<std::string> parse_sha256(std::string_view text, const std::string& field);

/// The bytes of a stored file, mapped. Shared: they live as long as the last copy, also when the file is
/// removed.
struct StoredBytes {
  std::string_view bytes = {};
  std::shared_ptr<const void> owner = {};
};

struct FileStoreOptions {
  std::string folder;                                 ///< made when it does not exist
  std::uint64_t max_bytes = std::uint64_t{64} << 30;  ///< of all files, parts of uploads too
};

/// Thread-safe. Blocks on the disk.
class FileStore {
 public:
  /// Also removes what a server that died was writing. Errors: BadOption when the folder cannot be used, or
  /// another process uses it.
  static Result<std::unique_ptr<FileStore>> open(const FileStoreOptions& options);
  ~FileStore();
  FileStore(const FileStore&) = delete;
  FileStore& operator=(const FileStore&) = delete;

  /// Keeps the bytes, whose SHA-256 this is; on disk when it returns. Errors: StorageFull.
  Result<> put(std::string_view bytes, const std::string& sha256);

  bool has(const std::string& sha256) const;
  /// Errors: NotFound, OutOfMemory.
  Result<StoredBytes> map(const std::string& sha256) const;

  /// While it lives, sweep() leaves every file alone: between put() and the record that needs the file.
  [[nodiscard]] std::shared_lock<std::shared_mutex> hold() { return std::shared_lock(sweeping_); }
  /// Removes every file that is not among those that `in_use` gives, unless somebody holds them: then it does
  /// nothing. Errors: those of `in_use`.
  Result<> sweep(const std::function<Result<std::set<std::string>>()>& in_use);

  /// A file that grows, empty at first; `id` of letters and digits. Errors of all parts: StorageFull,
  /// NotFound.
  Result<> create_part(const std::string& id);
  /// Writes at the offset; on disk for good only after sync_part().
  Result<> write_part(const std::string& id, std::uint64_t offset, std::string_view bytes);
  Result<> sync_part(const std::string& id);
  /// Leaves so many bytes of it; gives how many there are then.
  Result<std::uint64_t> cut_part(const std::string& id, std::uint64_t size);
  /// Makes it a file like those of put() and gives its SHA-256; a part with another than `expected` (empty:
  /// any) is removed. Also UploadCorrupt.
  Result<std::string> finish_part(const std::string& id, const std::string& expected);
  void remove_part(const std::string& id);
  std::set<std::string> parts() const;  ///< the ids

  std::uint64_t bytes() const { return bytes_; }  ///< of all files and parts

 private:
  explicit FileStore(FileStoreOptions options) : options_(std::move(options)) {}
  Result<> prepare();
  Result<> take(std::uint64_t bytes);
  Result<> adopt(const std::string& path, const std::string& sha256, std::uint64_t size);
  void remove_file(const std::string& path);
  std::string path_of(const std::string& sha256) const;
  std::string part_path(const std::string& id) const;

  const FileStoreOptions options_;
  int lock_ = -1;  ///< of the folder, held by this process
  std::shared_mutex sweeping_;
  std::atomic<std::uint64_t> bytes_ = 0, temporary_ = 0;
};

}  // namespace burnish
