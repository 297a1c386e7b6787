#include "tests/server/raw_http.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <utility>

namespace burnish::testing {

RawHttp::RawHttp(int port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  connect(&address, sizeof(address));
}

RawHttp::RawHttp(const std::string& unix_path) : socket_(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  unix_path.copy(address.sun_path, sizeof(address.sun_path) - 1);
  connect(&address, sizeof(address));
}

void RawHttp::connect(const void* address, unsigned size) {
  const timeval patience{.tv_sec = 60, .tv_usec = 0};
  ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
  if (::connect(socket_, static_cast<const sockaddr*>(address), size) != 0) close();
}

RawHttp::~RawHttp() { close(); }

void RawHttp::close() {
  if (socket_ >= 0) ::close(socket_);
  socket_ = -1;
}

void RawHttp::reset() {
  const linger none{.l_onoff = 1, .l_linger = 0};
  ::setsockopt(socket_, SOL_SOCKET, SO_LINGER, &none, sizeof(none));
  close();
}

void RawHttp::half_close() { ::shutdown(socket_, SHUT_WR); }

bool RawHttp::send(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
  return true;
}

bool RawHttp::send_request(std::string_view method, std::string_view target, std::string_view body,
                           std::string_view headers) {
  const std::string head = std::string(method) + " " + std::string(target) +
                           " HTTP/1.1\r\nHost: test\r\nContent-Length: " + std::to_string(body.size()) +
                           "\r\n" + std::string(headers) + "\r\n";
  return send(head) && send(body);
}

bool RawHttp::fill() {
  std::array<char, 65536> chunk;
  const ssize_t got = ::recv(socket_, chunk.data(), chunk.size(), 0);
  if (got <= 0) return false;
  buffer_.append(chunk.data(), static_cast<std::size_t>(got));
  return true;
}

HttpResponse RawHttp::read_head() {
  std::size_t end = 0;
  while ((end = buffer_.find("\r\n\r\n")) == std::string::npos) {
    if (!fill()) return {.status = 0};
  }
  const std::string head = buffer_.substr(0, end + 2);
  buffer_.erase(0, end + 4);
  HttpResponse response{.status = std::stoi(head.substr(head.find(' ')))};
  for (std::size_t line = head.find("\r\n") + 2; line < head.size();) {
    const std::size_t next = head.find("\r\n", line), colon = head.find(": ", line);
    response.headers[head.substr(line, colon - line)] = head.substr(colon + 2, next - colon - 2);
    line = next + 2;
  }
  return response;
}

std::string RawHttp::read(std::size_t size) {
  while (buffer_.size() < size && fill()) {
  }
  std::string result = buffer_.substr(0, size);
  buffer_.erase(0, result.size());
  return result;
}

std::string RawHttp::read_all() {
  while (fill()) {
  }
  return std::exchange(buffer_, {});
}

HttpResponse RawHttp::read_response(bool expect_body) {
  HttpResponse response = read_head();
  while (response.status == 100) response = read_head();
  const auto length = response.headers.find("Content-Length");
  if (expect_body && length != response.headers.end()) response.body = read(std::stoul(length->second));
  return response;
}

std::string chunked(std::string_view body, std::size_t size) {
  std::string chunks;
  while (!body.empty()) {
    const std::string_view piece = body.substr(0, size);
    std::array<char, 20> length{};
    const auto end = std::to_chars(length.data(), length.data() + length.size(), piece.size(), 16).ptr;
    chunks.append(length.data(), end).append("\r\n").append(piece).append("\r\n");
    body.remove_prefix(piece.size());
  }
  return chunks;
}

HttpResponse http_call(int port, std::string_view method, std::string_view target, std::string_view body,
                       std::string_view headers) {
  RawHttp connection(port);
  connection.send_request(method, target, body, headers);
  return connection.read_response(method != "HEAD");
}

}  // namespace burnish::testing
