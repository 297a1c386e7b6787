#include "server/http/connection.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

namespace burnish {
namespace {

using Clock = Connection::Clock;
using std::chrono::milliseconds;

constexpr milliseconds kAskEvery{5'000};
/// For a client that keeps sending after its answer, and for one that neither sends nor closes.
constexpr milliseconds kLongestLinger{10'000}, kLongestQuiet{2'000};

constexpr std::uint64_t kMostEarningBytes =
    1'000'000'000;  ///< more would overflow the clock at 1 byte a second

/// What ::poll() takes; rounded up, so that it never returns just before the time.
int poll_time(Clock::time_point until) {
  const auto left = std::chrono::ceil<milliseconds>(until - Clock::now()).count();
  return static_cast<int>(std::clamp<std::int64_t>(left, 0, 3'600'000));
}

bool wait_for(int socket, short what, Clock::time_point until, int stop = -1) {
  std::array<pollfd, 2> files{pollfd{socket, what, 0}, pollfd{stop, POLLIN, 0}};
  int ready = 0;
  do {
    ready = ::poll(files.data(), files.size(), poll_time(until));
  } while (ready < 0 && errno == EINTR);
  return ready > 0;
}

bool is_unix(int socket) {
  int domain = 0;
  socklen_t size = sizeof(domain);
  return ::getsockopt(socket, SOL_SOCKET, SO_DOMAIN, &domain, &size) == 0 && domain == AF_UNIX;
}

bool must_wait(int failure) { return failure == EAGAIN || failure == EWOULDBLOCK; }

}  // namespace

Clock::time_point HttpPatience::deadline(Clock::time_point begun, milliseconds grace,
                                         std::uint64_t bytes) const {
  const auto stalled = Clock::now() + stall;
  if (min_body_rate == 0) return stalled;
  const milliseconds earned(std::min(bytes, kMostEarningBytes) * 1000 / min_body_rate);
  return std::min(stalled, begun + grace + earned);
}

StopEvent::StopEvent() : file_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}

StopEvent::~StopEvent() {
  if (file_ >= 0) ::close(file_);
}

void StopEvent::set() {
  set_ = true;
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written = ::write(file_, &one, sizeof(one));
}

SocketConnection::SocketConnection(int socket, const StopEvent& stop, const HttpPatience& patience)
    : socket_(socket), stop_(stop), patience_(patience), tells_gone_(is_unix(socket)) {}

SocketConnection::~SocketConnection() { ::close(socket_); }

void SocketConnection::abort() { ::shutdown(socket_, SHUT_RDWR); }

Connection::Received Connection::drop(std::size_t most, Clock::time_point until) {
  std::array<char, 16384> dropped;
  return receive(std::span(dropped).first(std::min(most, dropped.size())), until);
}

Connection::Received SocketConnection::receive(std::span<char> into, Clock::time_point until) {
  return receive(into.data(), into.size(), 0, until);
}

/// TCP drops them in the kernel, without a copy; a Unix socket would count but give them.
Connection::Received SocketConnection::drop(std::size_t most, Clock::time_point until) {
  return tells_gone_ ? Connection::drop(most, until) : receive(nullptr, most, MSG_TRUNC, until);
}

Connection::Received SocketConnection::receive(char* into, std::size_t size, int how,
                                               Clock::time_point until) {
  while (true) {
    if (stop_.is_set()) return {Event::Stopping};
    const ssize_t got = ::recv(socket_, into, size, how | MSG_DONTWAIT);
    if (got > 0) return {Event::Bytes, static_cast<std::size_t>(got)};
    if (got < 0 && errno == EINTR) continue;
    if (got == 0 || !must_wait(errno)) return {Event::End};
    if (!wait_for(socket_, POLLIN, until, stop_.file())) return {Event::TimedOut};
  }
}

bool SocketConnection::send(std::string_view first, std::string_view second) {
  const auto begun = Clock::now();
  std::uint64_t taken = 0;
  while (!first.empty() || !second.empty()) {
    std::array<iovec, 2> pieces{iovec{const_cast<char*>(first.data()), first.size()},
                                iovec{const_cast<char*>(second.data()), second.size()}};
    msghdr message{};
    message.msg_iov = pieces.data();
    message.msg_iovlen = pieces.size();
    const ssize_t sent = ::sendmsg(socket_, &message, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent >= 0) {
      const auto size = static_cast<std::size_t>(sent);
      const std::size_t of_first = std::min(size, first.size());
      first.remove_prefix(of_first);
      second.remove_prefix(size - of_first);
      taken += size;
      continue;
    }
    if (errno == EINTR) continue;
    if (!must_wait(errno)) return false;
    if (!wait_for(socket_, POLLOUT, patience_.deadline(begun, patience_.stall, taken))) return false;
  }
  return true;
}

bool SocketConnection::gone(std::string_view question) {
  pollfd file{socket_, POLLRDHUP, 0};
  if (::poll(&file, 1, 0) <= 0) return false;
  if (file.revents & (POLLERR | POLLHUP | POLLNVAL)) return true;
  if (tells_gone_) return false;  // a closed one would show POLLHUP
  if (question.empty()) return true;
  if (Clock::now() < ask_again_) return false;
  ask_again_ = Clock::now() + kAskEvery;
  ::send(socket_, question.data(), question.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  return false;  // whoever is gone answers with a reset, which shows as POLLHUP the next time
}

void SocketConnection::linger() {
  ::shutdown(socket_, SHUT_WR);
  std::array<char, 65536> dropped;
  for (const auto end = Clock::now() + kLongestLinger; Clock::now() < end;) {
    if (!wait_for(socket_, POLLIN, std::min(end, Clock::now() + kLongestQuiet))) return;
    const ssize_t got = ::recv(socket_, dropped.data(), dropped.size(), MSG_DONTWAIT);
    if (got == 0 || (got < 0 && !must_wait(errno) && errno != EINTR)) return;
  }
}

Connection::Received MemoryConnection::receive(std::span<char> into, Clock::time_point) {
  const std::size_t size = std::min(into.size(), input_.size());
  if (size == 0) return {Event::End};
  std::memcpy(into.data(), input_.data(), size);
  input_.remove_prefix(size);
  return {Event::Bytes, size};
}

bool MemoryConnection::send(std::string_view first, std::string_view second) {
  output_.append(first).append(second);
  return true;
}

}  // namespace burnish
