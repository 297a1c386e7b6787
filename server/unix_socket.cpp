#include "server/unix_socket.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

namespace burnish {
namespace {

Error cannot_listen(const std::string& path, const std::string& why) {
  return {Cause::BadOption, "cannot listen on unix:" + path + ": " + why};
}

/// Whether somebody accepts connections there. Never waits: a listener whose backlog is full is one, too.
bool has_listener(const sockaddr_un& address) {
  const int probe = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (probe < 0) return true;
  const int result = ::connect(probe, reinterpret_cast<const sockaddr*>(&address), sizeof address);
  const bool refused = result != 0 && (errno == ECONNREFUSED || errno == ENOENT);
  ::close(probe);
  return !refused;
}

}  // namespace

Result<> clear_unix_socket(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) {
    return cannot_listen(
        path, "a socket's path has less than " + std::to_string(sizeof address.sun_path) + " characters");
  }
  std::ranges::copy(path, address.sun_path);
  std::error_code failure;
  const auto status = std::filesystem::symlink_status(path, failure);
  if (status.type() == std::filesystem::file_type::not_found) return {};
  if (status.type() != std::filesystem::file_type::socket) {
    return cannot_listen(path, failure ? failure.message() : "the file is no socket");
  }
  if (has_listener(address)) return cannot_listen(path, "a server listens there already");
  if (!std::filesystem::remove(path, failure) && failure) return cannot_listen(path, failure.message());
  return {};
}

}  // namespace burnish
