#include "server/http/tls_connection.h"

#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/ssl.h>

#include <algorithm>
#include <utility>

namespace burnish {
namespace {

constexpr std::size_t kWrittenAtOnce = 256
                                       << 10;  // of a large answer, so that its encrypted form stays small

}  // namespace

TlsConnection::TlsConnection(Connection& outer, std::shared_ptr<SSL_CTX> context)
    : outer_(outer), context_(std::move(context)), ssl_(SSL_new(context_.get())) {
  in_ = BIO_new(BIO_s_mem());
  out_ = BIO_new(BIO_s_mem());
  SSL_set_bio(ssl_, in_, out_);
  SSL_set_accept_state(ssl_);
}

TlsConnection::~TlsConnection() { SSL_free(ssl_); }

/// More of what the client sends, encrypted.
Connection::Received TlsConnection::fill(Clock::time_point until) {
  if (!flush()) return {Event::End};
  const Received got = outer_.receive(piece_, until);
  if (got.event == Event::Bytes) BIO_write(in_, piece_.data(), static_cast<int>(got.size));
  return got;
}

bool TlsConnection::handshake(Clock::time_point until) {
  for (;;) {
    ERR_clear_error();
    const int done = SSL_do_handshake(ssl_);
    if (done == 1) return flush();
    if (SSL_get_error(ssl_, done) != SSL_ERROR_WANT_READ) {
      flush();  // the alert that says why
      return false;
    }
    if (fill(until).event != Event::Bytes) return false;
  }
}

Connection::Received TlsConnection::receive(std::span<char> into, Clock::time_point until) {
  for (;;) {
    ERR_clear_error();
    const int size =
        SSL_read(ssl_, into.data(), static_cast<int>(std::min<std::size_t>(into.size(), INT_MAX)));
    if (size > 0) return {Event::Bytes, static_cast<std::size_t>(size)};
    if (SSL_get_error(ssl_, size) != SSL_ERROR_WANT_READ) return {Event::End};
    const Received got = fill(until);
    if (got.event != Event::Bytes) return {got.event};
  }
}

bool TlsConnection::write(std::string_view bytes) {
  while (!bytes.empty()) {
    ERR_clear_error();
    const int size = SSL_write(ssl_, bytes.data(), static_cast<int>(std::min(bytes.size(), kWrittenAtOnce)));
    if (size <= 0 || !flush()) return false;
    bytes.remove_prefix(static_cast<std::size_t>(size));
  }
  return true;
}

bool TlsConnection::send(std::string_view first, std::string_view second) {
  return write(first) && write(second);
}

bool TlsConnection::flush() {
  char* bytes = nullptr;
  const long size = BIO_get_mem_data(out_, &bytes);
  if (size <= 0) return true;
  const bool sent = outer_.send({bytes, static_cast<std::size_t>(size)}, {});
  (void)BIO_reset(out_);
  return sent;
}

void TlsConnection::linger() {
  SSL_shutdown(ssl_);
  flush();
  outer_.linger();
}

}  // namespace burnish
