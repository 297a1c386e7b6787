// What the HTTP library reads requests from and writes heads of answers to. Includes its header: only for
// conversation.cpp.
#pragma once

#include <httplib.h>

#include <string>

#include "server/http/request_reader.h"

namespace burnish {

/// Keeps what is written until it is taken, or until a body is waited for, whose sender must see it: 100
/// Continue.
class RequestStream final : public httplib::Stream {
 public:
  RequestStream(Connection& connection, RequestReader& reader) : connection_(connection), reader_(reader) {}

  std::string take_written() { return std::exchange(written_, {}); }

  ssize_t read(char* into, std::size_t size) override {
    if (reader_.in_body() && !written_.empty() && !connection_.send(take_written(), {})) return -1;
    return reader_.read(into, size);
  }
  ssize_t write(const char* bytes, std::size_t size) override {
    written_.append(bytes, size);
    return static_cast<ssize_t>(size);
  }

  // Without these the library would take whatever follows a request without a body for its body.
  bool is_readable() const override { return false; }
  socket_t socket() const override { return INVALID_SOCKET; }

  bool wait_readable() const override { return true; }
  bool wait_writable() const override { return true; }
  void get_remote_ip_and_port(std::string&, int&) const override {}
  void get_local_ip_and_port(std::string&, int&) const override {}
  time_t duration() const override { return 0; }

 private:
  Connection& connection_;
  RequestReader& reader_;
  std::string written_;
};

}  // namespace burnish
