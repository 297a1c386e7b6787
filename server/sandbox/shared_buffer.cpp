#include "server/sandbox/shared_buffer.h"

#include <sys/mman.h>

#include <algorithm>
#include <cstring>
#include <limits>

namespace burnish {
namespace {

constexpr std::uint64_t kKept = 8 << 20, kStep = 1 << 20, kPiece = 4 << 20;

}  // namespace

File SharedBuffer::make(const char* name) {
  File file = File::adopt(::memfd_create(name, MFD_CLOEXEC | MFD_ALLOW_SEALING));
  if (file.is_open() && ::fcntl(file.get(), F_ADD_SEALS, F_SEAL_SHRINK) != 0) return {};
  return file;
}

SharedBuffer::~SharedBuffer() {
  if (address_) ::munmap(address_, mapped_);
}

/// Not by fstat(), which is a call on paths here, and those are filtered.
std::uint64_t SharedBuffer::size() const {
  const off_t end = ::lseek(file_.get(), 0, SEEK_END);
  return end < 0 ? 0 : static_cast<std::uint64_t>(end);
}

bool SharedBuffer::map(std::uint64_t size) {
  if (address_) ::munmap(address_, mapped_);
  address_ = nullptr;
  mapped_ = 0;
  void* const address =
      ::mmap(nullptr, size, writes_ ? PROT_READ | PROT_WRITE : PROT_READ, MAP_SHARED, file_.get(), 0);
  if (address == MAP_FAILED) return false;
  address_ = static_cast<char*>(address);
  mapped_ = size;
  return true;
}

Result<> SharedBuffer::write(std::uint64_t offset, std::string_view bytes, const RunControl& run) {
  if (bytes.empty()) return {};
  const std::uint64_t needed = (offset + bytes.size() + kStep - 1) / kStep * kStep;
  const bool has_room = (needed <= size() || ::ftruncate(file_.get(), static_cast<off_t>(needed)) == 0) &&
                        (needed <= mapped_ || map(needed));
  if (!has_room) return Error{Cause::OutOfMemory, "not enough memory to hand the mesh over"};
  for (std::uint64_t done = 0; done < bytes.size(); done += kPiece) {
    if (run.stopped()) return run.stop_error();
    const std::string_view piece = bytes.substr(done, kPiece);
    std::memcpy(address_ + offset + done, piece.data(), piece.size());
  }
  return {};
}

std::string_view SharedBuffer::read(std::uint64_t offset, std::uint64_t bytes) {
  if (bytes == 0 || offset > std::numeric_limits<std::uint64_t>::max() - bytes) return {};
  const std::uint64_t all = size();
  // All of it at once: what was read before stays where it is until there is more.
  if (offset + bytes > all || (all > mapped_ && !map(all))) return {};
  return {address_ + offset, bytes};
}

Result<std::string> SharedBuffer::copy(std::uint64_t bytes, const RunControl& run) {
  const std::string_view all = read(0, bytes);
  if (all.size() != bytes) return Error{Cause::Internal, "the helper process handed over less than it said"};
  std::string copied;
  copied.reserve(bytes);
  for (std::uint64_t done = 0; done < bytes; done += kPiece) {
    if (run.stopped()) return run.stop_error();
    copied += all.substr(done, kPiece);
  }
  return copied;
}

void SharedBuffer::tidy() const {
  const std::uint64_t all = size();
  if (all <= kKept) return;
  ::fallocate(file_.get(), FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, kKept,
              static_cast<off_t>(all - kKept));
}

}  // namespace burnish
