#include "server/sandbox/channel.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/time.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <string>

namespace burnish {
namespace {

constexpr std::uint32_t kLongestMessage = 64 << 20;
constexpr std::size_t kMostFiles = 2;
constexpr timeval kInTheMiddle{.tv_sec = 5, .tv_usec = 0};  // of a message, however long it is

union Control {
  cmsghdr header;
  std::array<char, CMSG_SPACE(kMostFiles * sizeof(int))> bytes;
};

void attach(msghdr& message, Control& control, std::span<const int> files) {
  message.msg_control = control.bytes.data();
  message.msg_controllen = CMSG_SPACE(files.size_bytes());
  cmsghdr* const header = CMSG_FIRSTHDR(&message);
  header->cmsg_level = SOL_SOCKET;
  header->cmsg_type = SCM_RIGHTS;
  header->cmsg_len = CMSG_LEN(files.size_bytes());
  std::memcpy(CMSG_DATA(header), files.data(), files.size_bytes());
}

void take_files(msghdr& message, std::vector<File>* files) {
  for (cmsghdr* header = CMSG_FIRSTHDR(&message); header; header = CMSG_NXTHDR(&message, header)) {
    if (header->cmsg_level != SOL_SOCKET || header->cmsg_type != SCM_RIGHTS) continue;
    const std::size_t count = (header->cmsg_len - CMSG_LEN(0)) / sizeof(int);
    for (std::size_t i = 0; i < count; ++i) {
      int file = -1;
      std::memcpy(&file, CMSG_DATA(header) + i * sizeof(int), sizeof(int));
      File owned = File::adopt(file);
      if (files) files->push_back(std::move(owned));
    }
  }
}

}  // namespace

std::pair<File, File> Channel::pair() {
  int ends[2] = {-1, -1};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) return {};
  for (const int end : ends) {
    ::setsockopt(end, SOL_SOCKET, SO_RCVTIMEO, &kInTheMiddle, sizeof kInTheMiddle);
    ::setsockopt(end, SOL_SOCKET, SO_SNDTIMEO, &kInTheMiddle, sizeof kInTheMiddle);
  }
  return {File::adopt(ends[0]), File::adopt(ends[1])};
}

bool Channel::send(const google::protobuf::MessageLite& message, std::span<const int> files) {
  const auto size = static_cast<std::uint32_t>(message.ByteSizeLong());
  std::string bytes(reinterpret_cast<const char*>(&size), sizeof size);
  if (!message.AppendToString(&bytes)) return false;
  Control control{};
  iovec part{bytes.data(), bytes.size()};
  msghdr header{};
  header.msg_iov = &part;
  header.msg_iovlen = 1;
  if (!files.empty()) attach(header, control, files.first(std::min(files.size(), kMostFiles)));
  const std::lock_guard lock(sending_);
  while (part.iov_len > 0) {
    const ssize_t sent = ::sendmsg(socket_.get(), &header, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    part.iov_base = static_cast<char*>(part.iov_base) + sent;
    part.iov_len -= static_cast<std::size_t>(sent);
    header.msg_control = nullptr;
    header.msg_controllen = 0;
  }
  return true;
}

Channel::Got Channel::receive(google::protobuf::MessageLite& message,
                              std::optional<std::chrono::milliseconds> timeout, std::vector<File>* files) {
  pollfd waiting{.fd = socket_.get(), .events = POLLIN, .revents = 0};
  const int ready = ::poll(&waiting, 1, timeout ? static_cast<int>(timeout->count()) : -1);
  if (ready == 0 || (ready < 0 && errno == EINTR)) return Got::Nothing;
  std::uint32_t size = 0;
  Control control{};
  iovec part{&size, sizeof size};
  msghdr header{};
  header.msg_iov = &part;
  header.msg_iovlen = 1;
  header.msg_control = control.bytes.data();
  header.msg_controllen = control.bytes.size();
  const ssize_t read = ::recvmsg(socket_.get(), &header, MSG_WAITALL | MSG_CMSG_CLOEXEC);
  take_files(header, files);
  if (read < 0 && errno == ECONNRESET) return Got::Unread;
  if (read != sizeof size || size > kLongestMessage) return Got::Gone;
  std::string bytes(size, '\0');
  if (!read_all(bytes.data(), bytes.size()) || !message.ParseFromString(bytes)) return Got::Gone;
  return Got::Message;
}

bool Channel::read_all(char* to, std::size_t size) {
  while (size > 0) {
    const ssize_t read = ::recv(socket_.get(), to, size, 0);
    if (read < 0 && errno == EINTR) continue;
    if (read <= 0) return false;
    to += read;
    size -= static_cast<std::size_t>(read);
  }
  return true;
}

}  // namespace burnish
