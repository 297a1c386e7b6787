// A small HTTP client on a bare socket, so that tests can also behave badly: vanish, stall, send half.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "server/http/http_message.h"

namespace burnish::testing {

/// One connection to 127.0.0.1. Reading waits for at most 60 s; a broken connection gives an empty answer.
class RawHttp {
 public:
  explicit RawHttp(int port);
  ~RawHttp();
  RawHttp(const RawHttp&) = delete;
  RawHttp& operator=(const RawHttp&) = delete;

  /// False when the other side is gone.
  bool send(std::string_view bytes);
  /// "POST /target HTTP/1.1" with Host, Content-Length and `headers` ("Name: value\r\n"), then the body.
  bool send_request(std::string_view method, std::string_view target, std::string_view body = {},
                    std::string_view headers = {});
  /// Status line and headers of the next response; status 0 when the connection ended.
  HttpResponse read_head();
  /// read_head() and the body that its Content-Length promises.
  HttpResponse read_response(bool expect_body = true);
  /// As many of the next `size` bytes as come.
  std::string read(std::size_t size);
  void close();

 private:
  bool fill();
  int socket_ = -1;
  std::string buffer_;
};

/// One request on its own connection.
HttpResponse http_call(int port, std::string_view method, std::string_view target, std::string_view body = {},
                       std::string_view headers = {});

}  // namespace burnish::testing
