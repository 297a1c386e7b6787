// What every path answers, whatever it does with meshes.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "server/http/routes.h"
#include "tests/server/gateway_house.h"
#include "tests/support/shapes.h"

namespace burnish {
namespace {

using nlohmann::json;
using House = testing::GatewayHouse;
using testing::body_of;
using testing::expect_problem;
using testing::smooth_request;

std::string small_mesh() { return testing::to_obj(testing::sphere(1)); }

TEST(GatewayPaths, ListsTheMethods) {
  House house;
  const HttpResponse response = house.get("/v1/methods");
  ASSERT_EQ(response.status, 200);
  EXPECT_EQ(response.headers.at("Content-Type"), "application/json");
  const json methods = body_of(response)["methods"];
  EXPECT_EQ(methods.size(), static_cast<std::size_t>(list_methods().methods_size()));
  EXPECT_EQ(methods[0]["name"], "auto");
}

TEST(GatewayPaths, IsReadyOnlyWhileServingButAliveAlways) {
  House house;
  EXPECT_EQ(house.get("/livez").status, 200);
  EXPECT_EQ(house.get("/readyz").status, 200);
  house.lifecycle.move_to(LifecycleState::Draining);
  EXPECT_EQ(house.get("/livez").status, 200);
  expect_problem(house.get("/readyz"), Cause::ShuttingDown);
  expect_problem(house.handle(smooth_request(small_mesh())), Cause::ShuttingDown);
}

TEST(GatewayPaths, AnswersUnknownPathsAndVerbs) {
  House house;
  for (const char* path : {"/", "/v1", "/v1/smooth/", "/v2/smooth", "//livez", ""}) {
    expect_problem(house.get(path), Cause::NotFound);
    expect_problem(house.handle({.method = "OPTIONS", .path = path}), Cause::NotFound);
  }
  struct Row {
    const char *method, *path, *allow;
  };
  for (const Row& row :
       {Row{"GET", "/v1/smooth", "POST, OPTIONS"}, Row{"HEAD", "/v1/smooth", "POST, OPTIONS"},
        Row{"PUT", "/v1/compare", "POST, OPTIONS"}, Row{"POST", "/v1/methods", "GET, HEAD, OPTIONS"},
        Row{"DELETE", "/livez", "GET, HEAD, OPTIONS"}, Row{"get", "/readyz", "GET, HEAD, OPTIONS"},
        Row{"POST", "/openapi.json", "GET, HEAD, OPTIONS"}, Row{"G", "/metrics", "GET, HEAD, OPTIONS"}}) {
    const HttpResponse response = house.handle({.method = row.method, .path = row.path});
    expect_problem(response, Cause::MethodNotAllowed);
    EXPECT_EQ(response.headers.at("Allow"), row.allow) << row.path;
  }
}

TEST(GatewayPaths, AnswersHeadAsGetAndOptionsOnEveryPath) {
  House house;
  for (const Route& route : kRoutes) {
    const std::string path(route.path);
    const HttpResponse options = house.handle({.method = "OPTIONS", .path = path});
    EXPECT_EQ(options.status, 204) << path;
    EXPECT_EQ(options.headers.at("Allow"), route.verbs) << path;
    EXPECT_TRUE(options.body.empty());
    if (route.takes_meshes() || route.is_kept()) continue;
    const HttpResponse head = house.handle({.method = "HEAD", .path = path});
    EXPECT_EQ(head.status, 200) << path;
    EXPECT_EQ(head.headers.at("Content-Type"), house.get(path).headers.at("Content-Type"));
  }
}

TEST(GatewayPaths, TakesOverAGoodRequestIdAndOnlyThat) {
  House house;
  const auto id_for = [&](const std::string& path, const std::string& given) {
    return house.handle({.method = "GET", .path = path, .headers = {{"burnish-request-id", given}}})
        .headers.at("Burnish-Request-Id");
  };
  for (const std::string& good : {std::string("a"), std::string("Scan_7.retry-2"), std::string(64, 'x')}) {
    for (const char* path : {"/livez", "/v1/methods", "/nowhere", "/metrics"})
      EXPECT_EQ(id_for(path, good), good);
  }
  for (const std::string& bad : {std::string(), std::string(65, 'x'), std::string("a b"), std::string("a\nb"),
                                 std::string("\xc3\xbc")}) {
    EXPECT_EQ(id_for("/livez", bad).size(), 16u) << bad;
  }
  HttpRequest request = smooth_request(small_mesh(), {{"iterations", "1"}});
  request.headers["Burnish-Request-Id"] = "mine";
  const HttpResponse response = house.handle(request);
  EXPECT_EQ(response.headers.at("Burnish-Request-Id"), "mine");
  EXPECT_EQ(json::parse(response.headers.at("Burnish-Report"))["requestId"], "mine");
}

TEST(GatewayPaths, GivesBrokenHttpTheTransportsStatus) {
  House house;
  const HttpResponse response = house.gateway.bad_request(431, {Cause::BadRequest, "too many headers"});
  EXPECT_EQ(response.status, 431);
  EXPECT_EQ(body_of(response)["status"], 431);
  EXPECT_EQ(body_of(response)["code"], "bad_request");
  EXPECT_EQ(body_of(response)["requestId"], response.headers.at("Burnish-Request-Id"));
}

}  // namespace
}  // namespace burnish
