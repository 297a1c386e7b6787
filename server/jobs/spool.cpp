#include "server/jobs/spool.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <utility>

namespace burnish {
namespace {

Error cannot_spool(int failure) {
  const std::string why = std::strerror(failure);
  return {Cause::StorageFull, "the server cannot keep the request on its disk: " + why};
}

std::string folder_or_default(const std::string& folder) {
  if (!folder.empty()) return folder;
  std::error_code failure;
  const auto temporary = std::filesystem::temp_directory_path(failure);
  return failure ? "/tmp" : temporary.string();
}

/// A file without a name: gone when it is closed, however the process ends. -1 and errno on failure.
int open_nameless(const std::string& folder) {
  std::string path = folder + "/burnish-spool-XXXXXX";
  const int file = ::mkostemp(path.data(), O_CLOEXEC);
  if (file >= 0) ::unlink(path.c_str());
  return file;
}

}  // namespace

Body::~Body() {
  told_.reset();
  if (mapped_) ::munmap(const_cast<char*>(mapped_), size_);
  if (file_ >= 0) ::close(file_);
  spool_.bytes_ -= size_;
}

Result<> Body::append(std::string_view bytes) {
  if (!spool_.take(bytes.size())) {
    return Error{Cause::MemoryFull,
                 "the requests at hand fill the server's spool (max-spool-bytes); try again later"};
  }
  size_ += bytes.size();  // from here on ~Body() gives them back
  if (file_ < 0 && size_ > spool_.options_.in_memory) {
    if (auto moved = move_to_file(); !moved) return moved;
  }
  if (file_ >= 0) return write(bytes);
  memory_.append(bytes);
  return {};
}

Result<> Body::move_to_file() {
  file_ = open_nameless(spool_.options_.folder);
  if (file_ < 0) return cannot_spool(errno);
  auto written = write(memory_);
  std::string().swap(memory_);
  return written;
}

Result<> Body::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return cannot_spool(written < 0 ? errno : ENOSPC);
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return {};
}

Result<std::string_view> Body::finish() {
  if (file_ < 0) return std::string_view(memory_);
  if (!mapped_) {
    void* const address = ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, file_, 0);
    if (address == MAP_FAILED) return Error{Cause::OutOfMemory, "the server cannot map the request"};
    mapped_ = static_cast<const char*>(address);
    told_ = std::make_unique<MappedFile>(std::string_view(mapped_, size_), file_);
  }
  return std::string_view(mapped_, size_);
}

Spool::Spool(const SpoolOptions& options)
    : options_({folder_or_default(options.folder), options.in_memory, options.max_bytes}) {}

Result<> Spool::check() const {
  std::error_code failure;  // told by the next line
  std::filesystem::create_directories(options_.folder, failure);
  const int file = open_nameless(options_.folder);
  if (file < 0) {
    return Error{Cause::BadOption,
                 "cannot write to the spool folder '" + options_.folder + "': " + std::strerror(errno)};
  }
  ::close(file);
  return {};
}

std::unique_ptr<Body> Spool::body(std::uint64_t expected) {
  std::unique_ptr<Body> body(new Body(*this));
  if (expected <= options_.in_memory) body->memory_.reserve(expected);
  return body;
}

bool Spool::take(std::uint64_t bytes) {
  std::uint64_t now = bytes_;
  do {
    if (bytes > options_.max_bytes || now > options_.max_bytes - bytes) return false;
  } while (!bytes_.compare_exchange_weak(now, now + bytes));
  return true;
}

}  // namespace burnish
