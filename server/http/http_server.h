// The gateway on a socket. The only part that knows the HTTP library, whose header takes long to compile.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>

#include "server/config.h"
#include "server/http/gateway.h"

namespace burnish {

struct HttpServerOptions {
  Address listen;
  std::uint64_t max_bytes = 0;  ///< of a body
  std::size_t smooth_calls =
      0;  ///< requests to smooth that may be read or wait at once; more are refused at once
};

class HttpServer {
 public:
  /// Opens the port and answers requests. Errors: BadOption when the port cannot open.
  static Result<std::unique_ptr<HttpServer>> start(const HttpServerOptions& options, Gateway& gateway);
  ~HttpServer();  ///< stop(), however long it takes

  const Address& address() const;  ///< with the port that was opened

  /// Takes no new connections, finishes the responses under way, refuses requests whose body is still coming.
  /// Requests must not wait for a job any more. True when all threads are gone; false when some are still
  /// there after `patience`, because a client draws out the head of its request. Safe to repeat.
  bool stop(std::chrono::milliseconds patience);

 private:
  struct Impl;
  explicit HttpServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace burnish
