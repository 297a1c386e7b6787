// A small HTTP client on a bare socket, so that tests can also behave badly: vanish, stall, send half.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "server/http/http_message.h"

namespace burnish::testing {

/// One connection to 127.0.0.1 or to a Unix socket. Reading waits for at most 60 s; a broken connection gives
/// an empty answer.
class RawHttp {
 public:
  explicit RawHttp(int port);
  explicit RawHttp(const std::string& unix_path);
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
  /// read_head(), but not of an interim response, and the body that its Content-Length promises.
  HttpResponse read_response(bool expect_body = true);
  /// As many of the next `size` bytes as come.
  std::string read(std::size_t size);
  /// Everything up to the end of the connection.
  std::string read_all();
  /// Whether the other side closed the connection, with nothing left to read.
  bool at_end() { return read(1).empty(); }
  bool connected() const { return socket_ >= 0; }

  void close();
  void reset();       ///< closes with a reset
  void half_close();  ///< sends no more, still reads

 private:
  void connect(const void* address, unsigned size);
  bool fill();
  int socket_ = -1;
  std::string buffer_;
};

/// "3\r\nabc\r\n" for each piece of at most `size` bytes, without the last chunk.
std::string chunked(std::string_view body, std::size_t size);

/// One request on its own connection.
HttpResponse http_call(int port, std::string_view method, std::string_view target, std::string_view body = {},
                       std::string_view headers = {});

}  // namespace burnish::testing
