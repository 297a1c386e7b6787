#include "client/cli/files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <istream>
#include <ostream>
#include <system_error>
#include <utility>

namespace burnish::cli {
namespace {

namespace fs = std::filesystem;

Error file_error(const char* what, const fs::path& path, int reason) {
  return {Cause::FileError, "cannot " + std::string(what) + " '" + path.string() +
                                "': " + std::generic_category().message(reason)};
}

/// An open file that closes itself.
class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() { close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  int get() const { return fd_; }
  bool ok() const { return fd_ >= 0; }
  /// False when the system only now finds that it could not write.
  bool close() { return fd_ < 0 || ::close(std::exchange(fd_, -1)) == 0; }

 private:
  int fd_;
};

bool write_all(int fd, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

/// Pipes and devices (/dev/stdout) must not be replaced by a file.
bool is_special(const fs::path& path) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  return fs::exists(status) && !fs::is_regular_file(status);
}

mode_t mode_for(const fs::path& path) {
  struct stat existing {};
  if (::stat(path.c_str(), &existing) == 0) return existing.st_mode & 07777;
  const mode_t mask = ::umask(0);
  ::umask(mask);
  return 0666 & ~mask;
}

/// A file beside `path` that is gone when this ends, unless it took the path's name.
class Draft {
 public:
  explicit Draft(const fs::path& path)
      : name_((path.parent_path() / ".burnish-XXXXXX").string()),
        file_(::mkstemp(name_.data())),
        exists_(file_.ok()) {}
  ~Draft() {
    if (exists_) ::unlink(name_.c_str());
  }
  Draft(const Draft&) = delete;
  Draft& operator=(const Draft&) = delete;

  bool ok() const { return exists_; }
  bool publish(const fs::path& path, std::string_view bytes) {
    const bool published = write_all(file_.get(), bytes) && ::fchmod(file_.get(), mode_for(path)) == 0 &&
                           file_.close() && ::rename(name_.c_str(), path.c_str()) == 0;
    exists_ = !published;
    return published;
  }

 private:
  std::string name_;
  Descriptor file_;
  bool exists_;
};

/// Where a chain of symbolic links ends, so that the link survives.
fs::path resolved(const fs::path& path) {
  std::error_code error;
  const fs::path real = fs::canonical(path, error);
  return error ? path : real;
}

}  // namespace

Result<std::string> read_file(const fs::path& path) {
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file.ok()) return file_error("read", path, errno);
  std::string bytes;
  struct stat status {};
  if (::fstat(file.get(), &status) == 0 && status.st_size > 0) {
    bytes.reserve(static_cast<std::size_t>(status.st_size) + 1);
  }
  constexpr std::size_t kPiece = std::size_t{1} << 20;
  for (;;) {
    const std::size_t size = bytes.size();
    bytes.resize(size < bytes.capacity() ? bytes.capacity() : size + kPiece);
    const ssize_t got = ::read(file.get(), bytes.data() + size, bytes.size() - size);
    const int reason = errno;
    bytes.resize(size + static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
    if (got < 0 && reason != EINTR) return file_error("read", path, reason);
    if (got == 0) return bytes;
  }
}

Result<> check_writable(const fs::path& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) return file_error("write", path, EISDIR);
  if (fs::exists(path, ignored) && ::access(path.c_str(), W_OK) != 0) return file_error("write", path, errno);
  if (is_special(path)) return {};
  errno = 0;
  if (const Draft draft(resolved(path)); !draft.ok()) return file_error("write", path, errno);
  return {};
}

Result<> write_file(const fs::path& path, std::string_view bytes) {
  if (is_special(path)) {
    Descriptor file(::open(path.c_str(), O_WRONLY | O_CLOEXEC));
    if (!file.ok() || !write_all(file.get(), bytes) || !file.close()) return file_error("write", path, errno);
    return {};
  }
  const fs::path target = resolved(path);
  Draft draft(target);
  if (!draft.ok() || !draft.publish(target, bytes)) return file_error("write", path, errno);
  return {};
}

Result<std::string> read_input(const std::string& name, const Console& console) {
  if (name != "-") return read_file(name);
  std::string bytes;
  constexpr std::size_t kPiece = std::size_t{1} << 20;
  while (console.in) {
    const std::size_t size = bytes.size();
    bytes.resize(std::max(2 * size, kPiece));
    console.in.read(bytes.data() + size, static_cast<std::streamsize>(bytes.size() - size));
    bytes.resize(size + static_cast<std::size_t>(console.in.gcount()));
  }
  if (console.in.bad()) return Error{Cause::FileError, "cannot read standard input"};
  return bytes;
}

Result<> check_output(const std::string& name) { return name == "-" ? Result<>() : check_writable(name); }

Result<> write_output(const std::string& name, std::string_view bytes, const Console& console) {
  if (name != "-") return write_file(name, bytes);
  if (console.out.write(bytes.data(), static_cast<std::streamsize>(bytes.size())).flush()) return {};
  return Error{Cause::FileError, "cannot write to standard output"};
}

}  // namespace burnish::cli
