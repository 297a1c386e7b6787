#include "server/healthcheck.h"

#include <netdb.h>
#include <openssl/ssl.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

namespace burnish {
namespace {

Error unhealthy(const std::string& why) { return {Cause::Unreachable, why}; }

class Socket {
 public:
  explicit Socket(int descriptor) : descriptor_(descriptor) {}
  ~Socket() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  Socket(Socket&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  Socket& operator=(Socket&&) = delete;
  int get() const { return descriptor_; }

  /// Reading, writing and connecting give up after so long.
  bool connect(const sockaddr* to, socklen_t size, std::chrono::seconds patience) const {
    const timeval limit{.tv_sec = patience.count(), .tv_usec = 0};
    return ::setsockopt(descriptor_, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit) == 0 &&
           ::setsockopt(descriptor_, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit) == 0 &&
           ::connect(descriptor_, to, size) == 0;
  }

 private:
  int descriptor_;
};

/// Where a server that listens there is found from the same machine.
std::string host_to_ask(const std::string& host) {
  if (host == "0.0.0.0") return "127.0.0.1";
  return host == "::" ? "::1" : host;
}

Result<Socket> connect_unix(const Address& address, std::chrono::seconds patience) {
  sockaddr_un to{};
  to.sun_family = AF_UNIX;
  address.path.copy(to.sun_path, sizeof to.sun_path - 1);
  Socket socket(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  if (socket.connect(reinterpret_cast<const sockaddr*>(&to), sizeof to, patience)) return socket;
  return unhealthy(std::strerror(errno));
}

Result<Socket> connect_tcp(const Address& address, std::chrono::seconds patience) {
  if (address.port == 0) return unhealthy("a port that the server chose cannot be known (http-listen)");
  addrinfo wanted{};
  wanted.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int failure =
      ::getaddrinfo(host_to_ask(address.host).c_str(), std::to_string(address.port).c_str(), &wanted, &found);
  if (failure != 0) return unhealthy(::gai_strerror(failure));
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> owner(found, ::freeaddrinfo);
  for (const addrinfo* each = found; each; each = each->ai_next) {
    Socket socket(::socket(each->ai_family, each->ai_socktype | SOCK_CLOEXEC, each->ai_protocol));
    if (socket.connect(each->ai_addr, each->ai_addrlen, patience)) return socket;
  }
  return unhealthy(std::strerror(errno));
}

using Stream = std::unique_ptr<BIO, void (*)(BIO*)>;

/// TLS on the socket; also null when the files cannot be used.
Stream encrypted(const TlsFiles& files, int socket) {
  const std::unique_ptr<SSL_CTX, void (*)(SSL_CTX*)> context(SSL_CTX_new(TLS_client_method()), SSL_CTX_free);
  if (SSL_CTX_use_certificate_chain_file(context.get(), files.certificate.c_str()) != 1 ||
      SSL_CTX_use_PrivateKey_file(context.get(), files.key.c_str(), SSL_FILETYPE_PEM) != 1) {
    return {nullptr, BIO_free_all};
  }
  Stream stream(BIO_new_ssl(context.get(), 1), BIO_free_all);
  BIO_push(stream.get(), BIO_new_socket(socket, BIO_NOCLOSE));
  return stream;
}

}  // namespace

Result<> check_health(const Config& config, std::chrono::seconds patience) {
  const Address& address = config.http_listen;
  const auto socket = address.is_unix() ? connect_unix(address, patience) : connect_tcp(address, patience);
  if (!socket) return socket.error();
  const Stream stream = config.tls.given() ? encrypted(config.tls, socket->get())
                                           : Stream(BIO_new_socket(socket->get(), BIO_NOCLOSE), BIO_free_all);
  if (!stream) return unhealthy("cannot use the certificate or its key (tls-certificate, tls-key)");
  constexpr std::string_view kRequest =
      "GET /readyz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
  std::array<char, 64> answer{};
  if (BIO_write(stream.get(), kRequest.data(), kRequest.size()) != static_cast<int>(kRequest.size()) ||
      BIO_read(stream.get(), answer.data(), answer.size() - 1) <= 0) {
    return unhealthy("no answer to GET /readyz within " + std::to_string(patience.count()) + " s");
  }
  const std::string_view status(answer.data());
  if (status.starts_with("HTTP/1.1 200 ")) return {};
  return unhealthy("GET /readyz answered '" + std::string(status.substr(0, status.find('\r'))) + "'");
}

}  // namespace burnish
