// The gateway on a socket: accepts clients, gives each a thread, ends them all.
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

#include "server/config.h"
#include "server/http/connection.h"
#include "server/http/gateway.h"

namespace burnish {

struct HttpServerOptions {
  Address listen = {};
  std::size_t max_connections = 1024;  ///< at once, each with a thread; more hear queue_full and are closed
  HttpPatience patience = {};
  const TlsContexts* tls = nullptr;  ///< must outlive the server; null: not encrypted
};

HttpServerOptions http_options(const Config& config);

/// Thread-safe. What it is given must outlive it.
class HttpServer {
 public:
  /// Opens the port and answers requests. Errors: BadOption when the port cannot open.
  static Result<std::unique_ptr<HttpServer>> start(const HttpServerOptions& options, Gateway& gateway,
                                                   Jobs& jobs);
  /// Only answer(); `options.listen` is ignored.
  static std::unique_ptr<HttpServer> without_port(const HttpServerOptions& options, Gateway& gateway,
                                                  Jobs& jobs);
  ~HttpServer();  ///< stop(zero)

  const Address& address() const;  ///< with the port that was opened

  /// Answers the requests in `bytes` as if one client had sent them on one connection and then closed its
  /// sending side. On this thread, without a socket.
  std::string answer(std::string_view bytes);

  /// Takes no new connections, finishes the answers under way for up to `patience`, refuses requests that are
  /// still coming, closes every connection. Jobs of its requests must have ended or be able to: after
  /// `patience` they are cancelled. Safe to repeat.
  void stop(std::chrono::milliseconds patience);

 private:
  struct Impl;
  explicit HttpServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace burnish
