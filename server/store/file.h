// A file descriptor that closes itself, and writing that ends whole or with a sentence.
#pragma once

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>

#include "core/run/error.h"

namespace burnish {

class File {
 public:
  File() = default;
  File(const std::string& path, int flags) : file_(::open(path.c_str(), flags | O_CLOEXEC, 0600)) {}
  static File adopt(int file) {
    File owned;
    owned.file_ = file;
    return owned;
  }
  ~File() {
    if (file_ >= 0) ::close(file_);  // NOLINT(clang-analyzer-core.UndefinedBinaryOperatorResult): loses pairs
  }
  File(File&& other) noexcept : file_(std::exchange(other.file_, -1)) {}
  File& operator=(File&&) = delete;

  bool is_open() const { return file_ >= 0; }
  int get() const { return file_; }
  int release() { return std::exchange(file_, -1); }

  std::uint64_t size() const {
    struct stat status {};
    return ::fstat(file_, &status) == 0 ? static_cast<std::uint64_t>(status.st_size) : 0;
  }

  /// Errors: StorageFull.
  Result<> write(std::uint64_t offset, std::string_view bytes) const {
    while (!bytes.empty()) {
      const ssize_t written = ::pwrite(file_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) return cannot_store(written < 0 ? errno : ENOSPC);
      offset += static_cast<std::uint64_t>(written);
      bytes.remove_prefix(static_cast<std::size_t>(written));
    }
    return {};
  }
  Result<> sync() const { return ::fsync(file_) == 0 ? Result<>() : cannot_store(errno); }

  static Error cannot_store(int failure) {
    return {Cause::StorageFull,
            "the server cannot write to its store: " + std::string(std::strerror(failure))};
  }

 private:
  int file_ = -1;
};

}  // namespace burnish
