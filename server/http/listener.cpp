#include "server/http/listener.h"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <deque>
#include <memory>
#include <optional>
#include <utility>

#include "server/unix_socket.h"

namespace burnish {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kBacklog = 1024;
constexpr int kTickMs = 50;  ///< between looks at those that were turned away, and when no file is to spare
constexpr std::chrono::seconds kFarewell{1};
constexpr std::size_t kMostTurnedAway = 128;
constexpr int kPiecesPerTick = 8;  ///< dropped of what each of them sends

int new_socket(int family, int protocol = 0) {
  return ::socket(family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, protocol);
}

std::optional<struct stat> file_at(const std::string& path) {
  struct stat file {};
  if (::lstat(path.c_str(), &file) != 0) return {};
  return file;
}

int port_of(int socket) {
  sockaddr_storage address{};
  socklen_t size = sizeof(address);
  ::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size);
  return ntohs(address.ss_family == AF_INET6 ? reinterpret_cast<const sockaddr_in6&>(address).sin6_port
                                             : reinterpret_cast<const sockaddr_in&>(address).sin_port);
}

/// Clients that were refused and have yet to read it; closing at once could reset the connection before they
/// do.
class TurnedAway {
 public:
  ~TurnedAway() {
    while (!clients_.empty()) close_first();
  }

  /// The answer fits into the buffer of a new connection, so nothing waits.
  void add(int socket, const std::string& answer) {
    ::send(socket, answer.data(), answer.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    ::shutdown(socket, SHUT_WR);
    if (clients_.size() == kMostTurnedAway) close_first();
    clients_.push_back({socket, Clock::now() + kFarewell});
  }

  bool empty() const { return clients_.empty(); }

  void close_those_done() {
    std::erase_if(clients_, [now = Clock::now()](const Client& client) {
      const bool done = client.until < now || is_done(client.socket);
      if (done) ::close(client.socket);
      return done;
    });
  }

 private:
  struct Client {
    int socket;
    Clock::time_point until;
  };

  /// Drops what the client sent; true when it closed.
  static bool is_done(int socket) {
    std::array<char, 65536> dropped;
    ssize_t got = 0;
    for (int i = 0; i < kPiecesPerTick; ++i) {
      got = ::recv(socket, dropped.data(), dropped.size(), MSG_DONTWAIT);
      if (got <= 0) break;
    }
    return got == 0 || (got < 0 && errno != EAGAIN);
  }
  void close_first() {
    ::close(clients_.front().socket);
    clients_.pop_front();
  }

  std::deque<Client> clients_;
};

}  // namespace

Error Listener::failure(const std::string& why) const {
  return {Cause::BadOption, "cannot listen on " + address_.text() + " for HTTP: " + why};
}

Result<std::unique_ptr<Listener>> Listener::open(const Address& address) {
  auto listener = std::unique_ptr<Listener>(new Listener(address));
  auto opened = address.is_unix() ? listener->open_unix() : listener->open_tcp();
  if (!opened) return std::move(opened).error();
  return listener;
}

Result<> Listener::open_tcp() {
  addrinfo hints{}, *found = nullptr;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE;
  const std::string port = std::to_string(address_.port);
  if (const int unknown = ::getaddrinfo(address_.host.c_str(), port.c_str(), &hints, &found)) {
    return failure(::gai_strerror(unknown));
  }
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> owner(found, ::freeaddrinfo);
  int error = 0;
  for (const addrinfo* each = found; each; each = each->ai_next) {
    socket_ = new_socket(each->ai_family, each->ai_protocol);
    const int on = 1;
    ::setsockopt(socket_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
    if (::bind(socket_, each->ai_addr, each->ai_addrlen) == 0 && ::listen(socket_, kBacklog) == 0) {
      address_.port = port_of(socket_);
      return {};
    }
    error = errno;
    ::close(std::exchange(socket_, -1));
  }
  return failure(std::strerror(error));
}

Result<> Listener::open_unix() {
  if (auto clear = clear_unix_socket(address_.path); !clear) return clear;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  address_.path.copy(address.sun_path, sizeof(address.sun_path) - 1);
  socket_ = new_socket(AF_UNIX);
  if (::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
    return failure(std::strerror(errno));
  }
  if (const auto file = file_at(address_.path)) file_ = file->st_ino;
  if (::listen(socket_, kBacklog) != 0) return failure(std::strerror(errno));
  return {};
}

Listener::~Listener() {
  if (file_ != 0) {
    const auto file = file_at(address_.path);
    if (file && file->st_ino == file_) ::unlink(address_.path.c_str());
  }
  if (socket_ >= 0) ::close(socket_);
}

void Listener::run(const StopEvent& stop, const std::function<bool(int)>& take,
                   const std::function<std::string()>& refusal) {
  TurnedAway turned_away;
  const int on = 1;
  while (!stop.is_set()) {
    std::array<pollfd, 2> files{pollfd{socket_, POLLIN, 0}, pollfd{stop.file(), POLLIN, 0}};
    ::poll(files.data(), files.size(), turned_away.empty() ? -1 : kTickMs);
    turned_away.close_those_done();
    const int client = ::accept4(socket_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (client < 0) {
      const bool exhausted = errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM;
      if (exhausted) ::poll(&files[1], 1, kTickMs);  // whatever else failed is that client's affair
      continue;
    }
    if (!address_.is_unix()) ::setsockopt(client, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
    if (!take(client)) turned_away.add(client, refusal());
  }
}

}  // namespace burnish
