// Memory that burnishd and a helper both map: one writes, the other reads.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/run/run_control.h"
#include "server/store/file.h"

namespace burnish {

/// One end of it. Stays mapped, so that the next mesh finds pages that are there. Not thread-safe.
class SharedBuffer {
 public:
  /// That can grow but not shrink, so that no end pulls it from under the other. Not open when memory is out.
  static File make(const char* name);

  SharedBuffer(File file, bool writes) : file_(std::move(file)), writes_(writes) {}
  ~SharedBuffer();
  SharedBuffer(const SharedBuffer&) = delete;
  SharedBuffer& operator=(const SharedBuffer&) = delete;

  const File& file() const { return file_; }

  /// Makes room and copies, in pieces between which a stop is heard. OutOfMemory, Cancelled or
  /// DeadlineExceeded.
  Result<> write(std::uint64_t offset, std::string_view bytes, const RunControl& run);
  /// A copy of what read() gives, made likewise. Internal when the buffer does not go so far.
  Result<std::string> copy(std::uint64_t bytes, const RunControl& run);
  /// What the other end wrote, until it writes beyond what it ever wrote; empty when the buffer does not go
  /// so far.
  std::string_view read(std::uint64_t offset, std::uint64_t bytes);
  /// Gives the pages back that only large meshes need.
  void tidy() const;

 private:
  std::uint64_t size() const;
  bool map(std::uint64_t size);

  const File file_;
  const bool writes_;
  char* address_ = nullptr;
  std::uint64_t mapped_ = 0;
};

}  // namespace burnish
