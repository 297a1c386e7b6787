// Bytes on the disk for those writes that make room: when it is full, a job can still be removed.
#pragma once

#include <cstdint>
#include <string>

#include "server/store/file.h"

namespace burnish {

class Reserve {
 public:
  Reserve(const std::string& path, std::uint64_t bytes) : file_(path, O_RDWR | O_CREAT), bytes_(bytes) {
    hold();
  }

  /// Takes what it can get; that may be less than all.
  void hold() {
    if (file_.is_open() && file_.size() < bytes_)
      (void)::posix_fallocate(file_.get(), 0, static_cast<off_t>(bytes_));
  }

  /// Gives it back to the disk. False: there was nothing.
  bool release() { return file_.is_open() && file_.size() > 0 && ::ftruncate(file_.get(), 0) == 0; }

 private:
  File file_;
  std::uint64_t bytes_;
};

}  // namespace burnish
