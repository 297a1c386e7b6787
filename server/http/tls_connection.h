// A connection inside TLS on another one, whose waiting, limits of time and end it inherits.
#pragma once

#include <array>
#include <memory>

#include "server/http/connection.h"

struct ssl_ctx_st;
struct ssl_st;
struct bio_st;

namespace burnish {

class TlsConnection final : public Connection {
 public:
  /// `outer` must outlive it.
  TlsConnection(Connection& outer, std::shared_ptr<ssl_ctx_st> context);
  ~TlsConnection() override;
  TlsConnection(const TlsConnection&) = delete;
  TlsConnection& operator=(const TlsConnection&) = delete;

  /// Before anything else. False: the client speaks no TLS, shows no certificate that is asked for, is too
  /// slow or gone.
  bool handshake(Clock::time_point until);

  Received receive(std::span<char> into, Clock::time_point until) override;
  bool send(std::string_view first, std::string_view second) override;
  /// A client that closed its sending side counts as gone.
  bool gone(std::string_view) override { return outer_.gone({}); }
  void linger() override;
  bool stopping() const override { return outer_.stopping(); }

 private:
  Received fill(Clock::time_point until);
  bool write(std::string_view bytes);
  bool flush();

  Connection& outer_;
  const std::shared_ptr<ssl_ctx_st> context_;
  ssl_st* const ssl_;
  bio_st *in_ = nullptr, *out_ = nullptr;  ///< what came, and what is to go, encrypted; ssl_ owns them
  std::array<char, 16 << 10> piece_;
};

}  // namespace burnish
