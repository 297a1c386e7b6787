// Where the bytes of a request wait until they are all there: in memory while they are few, else in a file
// without a name that disappears with the process. So callers that send slowly, or far too much, cost disk,
// not memory.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "core/run/error.h"
#include "server/mapped_files.h"

namespace burnish {

struct SpoolOptions {
  std::string folder = {};                           ///< empty: the system's temporary folder
  std::uint64_t in_memory = std::uint64_t{2} << 20;  ///< of each body, in bytes; more goes to a file
  std::uint64_t max_bytes = std::uint64_t{8} << 30;  ///< of all bodies together
};

class Spool;

/// The bytes of one file that a request carries. Filled by one thread, then read by any.
class Body {
 public:
  ~Body();
  Body(const Body&) = delete;
  Body& operator=(const Body&) = delete;

  /// Errors: MemoryFull when the spool's limit is reached, StorageFull when the disk is.
  Result<> append(std::string_view bytes);

  /// No more append(). The view lives as long as the Body. Errors: OutOfMemory when the file cannot be
  /// mapped.
  Result<std::string_view> finish();

  std::uint64_t size() const { return size_; }

 private:
  friend class Spool;
  explicit Body(Spool& spool) : spool_(spool) {}
  Result<> move_to_file();
  Result<> write(std::string_view bytes);

  Spool& spool_;
  std::string memory_;
  int file_ = -1;
  const char* mapped_ = nullptr;
  std::unique_ptr<MappedFile> told_;  ///< that the file is mapped
  std::uint64_t size_ = 0;
};

/// Thread-safe. Must outlive its bodies.
class Spool {
 public:
  explicit Spool(const SpoolOptions& options = {});

  /// Proves that the folder can be written to. Errors: BadOption.
  Result<> check() const;

  /// `expected`: so many bytes are to come, as far as the caller knows; 0: no word. Only where memory grows
  /// from.
  std::unique_ptr<Body> body(std::uint64_t expected = 0);
  std::uint64_t bytes() const { return bytes_; }  ///< of all bodies that live

 private:
  friend class Body;
  bool take(std::uint64_t bytes);

  const SpoolOptions options_;
  std::atomic<std::uint64_t> bytes_ = 0;
};

}  // namespace burnish
