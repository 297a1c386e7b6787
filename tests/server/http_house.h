// An HTTP server on a free port, whose jobs give their mesh back as it came.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "server/http/http_server.h"
#include "tests/server/gateway_house.h"
#include "tests/server/raw_http.h"

namespace burnish::testing {

inline SmoothFunction echo(Format format = Format::Obj) {
  return [format](const SmoothJob& job, const RunControl&) -> Result<SmoothResult> {
    SmoothResult result;
    result.mesh = job.mesh;
    result.format = format;
    return result;
  };
}

/// `mesh` must outlive the house.
inline SmoothFunction answer_with(const std::string& mesh) {
  return [&mesh](const SmoothJob&, const RunControl&) -> Result<SmoothResult> {
    SmoothResult result;
    result.mesh = mesh;
    return result;
  };
}

struct HttpHouse {
  explicit HttpHouse(HttpServerOptions options = {}, SmoothFunction smooth = echo())
      : house({.smooth = std::move(smooth)}) {
    if (!options.listen.is_unix()) options.listen = {.host = "127.0.0.1", .port = 0};
    server = HttpServer::start(options, house.gateway, house.jobs).value();
  }

  int port() const { return server->address().port; }
  HttpResponse call(std::string_view method, std::string_view target, std::string_view body = {},
                    std::string_view headers = {}) {
    return http_call(port(), method, target, body, headers);
  }

  GatewayHouse house;
  std::unique_ptr<HttpServer> server;
};

/// "too_large" of a problem; empty for anything else.
inline std::string code_of(const HttpResponse& response) {
  const auto type = response.headers.find("Content-Type");
  if (type == response.headers.end() || type->second != "application/problem+json") return "";
  return nlohmann::json::parse(response.body)["code"];
}
inline std::string detail_of(const HttpResponse& response) {
  return code_of(response).empty() ? "" : std::string(nlohmann::json::parse(response.body)["detail"]);
}

/// A form with the boundary "x".
inline std::string form_of(const std::vector<Part>& parts) {
  std::string form;
  for (const Part& part : parts) {
    form += "--x\r\nContent-Disposition: form-data; name=\"" + part.name + "\"\r\n";
    if (!part.type.empty()) form += "Content-Type: " + part.type + "\r\n";
    form += "\r\n" + part.content + "\r\n";
  }
  return form + "--x--\r\n";
}
inline constexpr std::string_view kFormType = "Content-Type: multipart/form-data; boundary=x\r\n";

/// Of this process, in bytes.
inline std::uint64_t resident_memory() {
  std::ifstream status("/proc/self/status");
  std::string word;
  while (status >> word && word != "VmRSS:") {
  }
  std::uint64_t kilobytes = 0;
  status >> kilobytes;
  return kilobytes << 10;
}

/// Sanitizers keep freed memory and add their own.
#if defined(__SANITIZE_ADDRESS__) || defined(_GLIBCXX_TSAN)
inline constexpr bool kMemoryIsTelling = false;
#else
inline constexpr bool kMemoryIsTelling = true;
#endif

}  // namespace burnish::testing
