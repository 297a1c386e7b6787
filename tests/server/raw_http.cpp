#include "tests/server/raw_http.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <stdexcept>

namespace burnish::testing {

RawHttp::RawHttp(int port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  const timeval patience{.tv_sec = 60, .tv_usec = 0};
  ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) close();
}

RawHttp::~RawHttp() { close(); }

void RawHttp::close() {
  if (socket_ >= 0) ::close(socket_);
  socket_ = -1;
}

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

HttpResponse RawHttp::read_response(bool expect_body) {
  HttpResponse response = read_head();
  const auto length = response.headers.find("Content-Length");
  if (expect_body && length != response.headers.end()) response.body = read(std::stoul(length->second));
  return response;
}

HttpResponse http_call(int port, std::string_view method, std::string_view target, std::string_view body,
                       std::string_view headers) {
  RawHttp connection(port);
  connection.send_request(method, target, body, headers);
  return connection.read_response(method != "HEAD");
}

}  // namespace burnish::testing
