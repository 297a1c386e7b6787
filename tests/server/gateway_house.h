// A gateway with everything behind it, and no socket.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "server/http/gateway.h"
#include "server/status_map.h"
#include "tests/server/jobs_house.h"

namespace burnish::testing {

struct GatewaySetting {
  SmoothFunction smooth = {};
  GatewayOptions gateway = {};
  std::chrono::milliseconds longest_run = std::chrono::seconds(60);
};

struct GatewayHouse : JobsHouse {
  explicit GatewayHouse(GatewaySetting setting = {})
      : JobsHouse({.limits = {.mesh = {.max_bytes = 100'000}},
                   .runner = {.workers = 1, .queue = 1, .longest_run = setting.longest_run},
                   .smooth = std::move(setting.smooth)}),
        gateway(jobs, durable_jobs, uploads, std::move(setting.gateway)) {}

  HttpResponse handle(const HttpRequest& request) {
    return gateway.handle(request, [] { return false; });
  }
  HttpResponse get(const std::string& path) { return handle({.method = "GET", .path = path}); }

  Gateway gateway;
};

inline SharedBytes shared_bytes(std::string bytes) {
  const auto owner = std::make_shared<const std::string>(std::move(bytes));
  return {.bytes = *owner, .owner = owner};
}

inline HttpRequest smooth_request(std::string mesh, std::multimap<std::string, std::string> query = {}) {
  return {.method = "POST",
          .path = "/v1/smooth",
          .query = std::move(query),
          .body = shared_bytes(std::move(mesh))};
}

struct Part {
  std::string name, content, type = {};
};

inline HttpRequest form_request(std::string path, const std::vector<Part>& parts,
                                std::multimap<std::string, std::string> query = {}) {
  HttpRequest request{.method = "POST",
                      .path = std::move(path),
                      .query = std::move(query),
                      .headers = {{"Content-Type", "multipart/form-data; boundary=x"}}};
  for (const Part& part : parts) request.parts.push_back({part.name, part.type, shared_bytes(part.content)});
  return request;
}

inline nlohmann::json body_of(const HttpResponse& response) { return nlohmann::json::parse(response.body); }

/// Every member of a problem, against the status map.
inline void expect_problem(const HttpResponse& response, Cause cause) {
  const StatusRow& row = status_of(cause);
  EXPECT_EQ(response.status, row.http_status) << response.body;
  ASSERT_EQ(response.headers.at("Content-Type"), "application/problem+json");
  const nlohmann::json problem = body_of(response);
  EXPECT_EQ(problem["code"], cause_code(cause)) << response.body;
  EXPECT_EQ(problem["status"], row.http_status);
  EXPECT_EQ(problem["title"], row.title);
  EXPECT_EQ(problem["type"], "urn:burnish:problem:" + std::string(cause_code(cause)));
  EXPECT_FALSE(problem["detail"].get<std::string>().empty());
  EXPECT_EQ(problem["requestId"].get<std::string>().size(), 16u);
  EXPECT_EQ(problem["requestId"], response.headers.at("Burnish-Request-Id"));
}

}  // namespace burnish::testing
