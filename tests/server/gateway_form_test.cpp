// Multipart requests, negotiated answers and callers in browsers.
#include <absl/strings/escaping.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "server/http/routes.h"
#include "server/status_map.h"
#include "tests/server/gateway_house.h"
#include "tests/support/shapes.h"

namespace burnish {
namespace {

using nlohmann::json;
using House = testing::GatewayHouse;
using testing::form_request;
using ::testing::HasSubstr;
using testing::Part;
using testing::smooth_request;

const std::string& noisy() {
  static const std::string kMesh = testing::to_obj(testing::with_noise(testing::sphere(1), 0.05));
  return kMesh;
}
const std::string& clean() {
  static const std::string kMesh = testing::to_obj(testing::sphere(1));
  return kMesh;
}

json problem_of(const HttpResponse& response) {
  EXPECT_EQ(response.headers.at("Content-Type"), "application/problem+json") << response.status;
  return json::parse(response.body);
}

TEST(GatewayForm, AnswersTheSameMeshAsTheRawBody) {
  House house;
  const HttpResponse raw = house.handle(smooth_request(noisy(), {{"method", "taubin"}, {"iterations", "3"}}));
  ASSERT_EQ(raw.status, 200) << raw.body;
  const HttpResponse by_options = house.handle(form_request(
      "/v1/smooth", {{"options", R"({"method":"taubin","iterations":3})"}, {"mesh", noisy(), "model/obj"}}));
  const HttpResponse by_query = house.handle(
      form_request("/v1/smooth", {{"mesh", noisy()}}, {{"method", "taubin"}, {"iterations", "3"}}));
  EXPECT_EQ(by_options.body, raw.body);
  EXPECT_EQ(by_query.body, raw.body);
  EXPECT_EQ(by_options.headers.at("Content-Type"), "model/obj");
}

TEST(GatewayForm, MeasuresAgainstTheReference) {
  House house;
  const HttpResponse response =
      house.handle(form_request("/v1/smooth", {{"mesh", noisy()}, {"reference", clean()}},
                                {{"iterations", "1"}, {"timeout_ms", "60000"}}));
  ASSERT_EQ(response.status, 200) << response.body;
  EXPECT_EQ(json::parse(response.headers.at("Burnish-Report"))["errors"]["against"], "reference");
}

TEST(GatewayForm, NamesThePartThatIsWrong) {
  struct Row {
    std::string path;
    std::vector<Part> parts;
    std::multimap<std::string, std::string> query;
    Cause cause;
    const char* field;
  };
  const std::string smooth = "/v1/smooth", compare = "/v1/compare";
  const Row rows[] = {
      {smooth, {}, {}, Cause::BadOption, "mesh"},
      {smooth, {{"mesh", ""}}, {}, Cause::EmptyMesh, "mesh"},
      {smooth, {{"mesh", noisy()}, {"mesh", noisy()}}, {}, Cause::BadOption, "mesh"},
      {smooth, {{"mesh", noisy()}, {"Mesh", noisy()}}, {}, Cause::UnknownOption, "Mesh"},
      {smooth, {{"mesh", noisy()}, {"", noisy()}}, {}, Cause::UnknownOption, ""},
      {smooth, {{"mesh", noisy(), "image/png"}}, {}, Cause::UnsupportedFormat, "mesh"},
      {smooth, {{"mesh", noisy()}, {"reference", ""}}, {}, Cause::EmptyMesh, "reference"},
      {smooth, {{"mesh", noisy()}, {"reference", clean(), "a/b"}}, {}, Cause::UnsupportedFormat, "reference"},
      {smooth, {{"mesh", noisy()}, {"options", "{"}}, {}, Cause::BadOption, "options"},
      {smooth, {{"mesh", noisy()}, {"options", R"({"a":1})"}}, {}, Cause::UnknownOption, "options.a"},
      {smooth, {{"mesh", noisy()}, {"options", "{}"}}, {{"iterations", "3"}}, Cause::BadOption, "iterations"},
      {smooth, {{"mesh", noisy()}, {"options", "{}"}}, {{"timeout_ms", "x"}}, Cause::BadOption, "timeout_ms"},
      {smooth, {{"mesh", noisy()}}, {{"colour", "red"}}, Cause::UnknownOption, "colour"},
      {compare, {{"mesh", noisy()}}, {}, Cause::BadOption, "reference"},
      {compare, {{"reference", clean()}}, {}, Cause::BadOption, "mesh"},
      {compare,
       {{"mesh", noisy()}, {"reference", clean()}, {"options", "{}"}},
       {},
       Cause::UnknownOption,
       "options"},
      {compare,
       {{"mesh", noisy()}, {"reference", clean()}},
       {{"method", "taubin"}},
       Cause::UnknownOption,
       "method"},
  };
  House house;
  for (const Row& row : rows) {
    const HttpResponse response = house.handle(form_request(row.path, row.parts, row.query));
    EXPECT_EQ(response.status, status_of(row.cause).http_status);
    const json problem = problem_of(response);
    EXPECT_EQ(problem["code"], cause_code(row.cause)) << response.body;
    EXPECT_EQ(problem.value("field", ""), row.field) << response.body;
  }
}

TEST(GatewayForm, RefusesAFormThatCannotFitByItsHeadAlone) {
  House house;
  HttpRequest head = form_request("/v1/smooth", {}, {{"anything", "may still be in the options' place"}});
  head.headers["Content-Length"] = "200000";  // two meshes at the limit of 100000
  EXPECT_FALSE(house.gateway.answer_head(head).has_value());
  head.headers["Content-Length"] = "400000";
  const auto refused = house.gateway.answer_head(head);
  ASSERT_TRUE(refused.has_value());
  EXPECT_EQ(refused->status, 413);
  EXPECT_THAT(refused->body, HasSubstr("(max-bytes)"));
}

TEST(GatewayCompare, AnswersTheErrorTable) {
  House house;
  const HttpResponse response = house.handle(
      form_request("/v1/compare", {{"reference", clean()}, {"mesh", noisy()}}, {{"timeout_ms", "60000"}}));
  ASSERT_EQ(response.status, 200) << response.body;
  EXPECT_EQ(response.headers.at("Content-Type"), "application/json");
  const json table = json::parse(response.body);
  EXPECT_GT(table["errors"]["ev"], 0);
  EXPECT_EQ(table["errors"]["against"], "reference");
  EXPECT_EQ(table["mesh"]["vertices"], 42);
  EXPECT_EQ(table["requestId"], response.headers.at("Burnish-Request-Id"));
}

TEST(GatewayCompare, TakesFormsOnlyAndSaysSoByTheHead) {
  House house;
  const auto answer = house.gateway.answer_head(
      {.method = "POST", .path = "/v1/compare", .headers = {{"Content-Type", "model/obj"}}});
  ASSERT_TRUE(answer.has_value());
  EXPECT_EQ(answer->status, 415);
  EXPECT_THAT(answer->body, HasSubstr("multipart/form-data"));
}

TEST(GatewayAccept, GivesJsonWithTheMeshInside) {
  House house;
  HttpRequest request = smooth_request(noisy(), {{"iterations", "2"}});
  const std::string mesh = house.handle(request).body;
  request.headers["Accept"] = "application/json";
  const HttpResponse response = house.handle(request);
  ASSERT_EQ(response.status, 200) << response.body;
  EXPECT_EQ(response.headers.at("Content-Type"), "application/json");
  EXPECT_FALSE(response.headers.contains("Burnish-Report"));
  const json answer = json::parse(response.body);
  std::string bytes;
  ASSERT_TRUE(absl::Base64Unescape(answer["mesh"].get<std::string>(), &bytes));
  EXPECT_EQ(bytes, mesh);
  EXPECT_EQ(answer["format"], "MESH_FORMAT_OBJ");
  EXPECT_EQ(answer["report"]["parameters"]["iterations"], 2);
  EXPECT_EQ(answer["report"]["requestId"], response.headers.at("Burnish-Request-Id"));
}

TEST(GatewayAccept, KeepsBase64WholeAcrossItsPieces) {
  for (const std::size_t size : {0u, 1u, 2u, 3u, 196'607u, 196'608u, 196'609u, 500'000u}) {
    std::string mesh(size, '\0');
    for (std::size_t i = 0; i < size; ++i) mesh[i] = static_cast<char>(i * 31 + i / 251);
    House house({.smooth = [&mesh](const SmoothJob&, const RunControl&) -> Result<SmoothResult> {
      return SmoothResult{.mesh = mesh, .format = Format::Draco, .report = {}};
    }});
    HttpRequest request = smooth_request("anything");
    request.headers["Accept"] = "application/json";
    const json answer = json::parse(house.handle(request).body);
    std::string bytes;
    ASSERT_TRUE(absl::Base64Unescape(answer["mesh"].get<std::string>(), &bytes)) << size;
    EXPECT_EQ(bytes, mesh) << size;
    EXPECT_EQ(answer["format"], "MESH_FORMAT_DRACO");
  }
}

TEST(GatewayAccept, FollowsTheQualities) {
  struct Row {
    const char* accept;
    const char* type;  ///< null: 406
  };
  const Row rows[] = {
      {"*/*", "model/obj"},
      {"model/*", "model/obj"},
      {"model/obj", "model/obj"},
      {"MODEL/OBJ ; q=0.2", "model/obj"},
      {"application/octet-stream", "application/octet-stream"},
      {"application/json, */*", "model/obj"},
      {"application/json, */*;q=0.1", "application/json"},
      {"application/json;q=0.1, model/*;q=0.2", "model/obj"},
      {"application/json;q=0.9, model/obj;q=0", "application/json"},
      {"*/*, model/obj;q=0", "application/json"},
      {"application/*", "application/json"},
      {"text/html,application/xhtml+xml,application/xml;q=0.9,*/*;q=0.8", "model/obj"},
      {"text/html", nullptr},
      {"model/vnd.draco", nullptr},
      {"*/*;q=0", nullptr},
      {"application/json;q=often", nullptr},
  };
  House house;
  for (const Row& row : rows) {
    HttpRequest request = smooth_request(noisy(), {{"iterations", "1"}});
    request.headers["Accept"] = row.accept;
    const HttpResponse response = house.handle(request);
    if (row.type) {
      EXPECT_EQ(response.headers.at("Content-Type"), row.type) << row.accept;
    } else {
      EXPECT_EQ(response.status, 406) << row.accept;
      EXPECT_EQ(problem_of(response)["code"], "not_acceptable");
    }
  }
}

TEST(GatewayAccept, KnowsTheFormatOfTheResult) {
  House house;
  HttpRequest request = smooth_request(noisy(), {{"iterations", "1"}, {"output", "drc"}});
  request.headers["Accept"] = "model/vnd.draco";
  EXPECT_EQ(house.handle(request).headers.at("Content-Type"), "model/vnd.draco");
  request.headers["Accept"] = "model/obj";
  EXPECT_EQ(house.handle(request).status, 406);
}

constexpr const char* kOrigin = "https://scans.example";

HttpResponse from_page(House& house, HttpRequest request, const std::string& origin) {
  request.headers["Origin"] = origin;
  return house.handle(request);
}

TEST(GatewayCors, IsOffByDefault) {
  House house;
  const HttpResponse response = from_page(house, {.method = "GET", .path = "/v1/methods"}, kOrigin);
  EXPECT_FALSE(response.headers.contains("Access-Control-Allow-Origin"));
  EXPECT_FALSE(response.headers.contains("Vary"));
}

TEST(GatewayCors, LetsListedPagesReadAnswersAndErrors) {
  House house({.gateway = {.cors_origins = {"http://localhost:3000", kOrigin}}});
  for (const HttpRequest& request :
       {HttpRequest{.method = "GET", .path = "/v1/methods"}, HttpRequest{.method = "GET", .path = "/nowhere"},
        smooth_request("no mesh"), smooth_request(noisy(), {{"iterations", "1"}})}) {
    const HttpResponse response = from_page(house, request, kOrigin);
    EXPECT_EQ(response.headers.at("Access-Control-Allow-Origin"), kOrigin);
    EXPECT_EQ(response.headers.at("Vary"), "Origin");
    for (const char* name : {"Burnish-Report", "Burnish-Request-Id", "Retry-After"}) {
      EXPECT_THAT(response.headers.at("Access-Control-Expose-Headers"), HasSubstr(name));
    }
    EXPECT_FALSE(response.headers.contains("Access-Control-Allow-Credentials"));
  }
  EXPECT_EQ(house.gateway
                .refuse({.method = "POST", .path = "/v1/smooth", .headers = {{"Origin", kOrigin}}},
                        {Cause::TooLarge, "too large"})
                .headers.at("Access-Control-Allow-Origin"),
            kOrigin);
}

TEST(GatewayCors, TellsOtherPagesNothing) {
  House house({.gateway = {.cors_origins = {kOrigin}}});
  for (const std::string origin : {"https://scans.example.evil", "http://scans.example", "null", ""}) {
    const HttpResponse response = from_page(house, {.method = "GET", .path = "/v1/methods"}, origin);
    EXPECT_EQ(response.status, 200);
    EXPECT_FALSE(response.headers.contains("Access-Control-Allow-Origin")) << origin;
    EXPECT_EQ(response.headers.at("Vary"), "Origin") << "or a cache mixes the answers up";
  }
}

TEST(GatewayCors, AnswersPreflights) {
  House house({.gateway = {.cors_origins = {"*"}}});
  HttpRequest request{.method = "OPTIONS",
                      .path = "/v1/smooth",
                      .headers = {{"Access-Control-Request-Method", "POST"},
                                  {"Access-Control-Request-Headers", "content-type"}}};
  const HttpResponse response = from_page(house, request, kOrigin);
  EXPECT_EQ(response.status, 204);
  EXPECT_EQ(response.headers.at("Access-Control-Allow-Origin"), kOrigin);
  EXPECT_EQ(response.headers.at("Access-Control-Allow-Methods"), "POST, OPTIONS");
  for (const char* name :
       {"Content-Type", "Accept", "Content-Encoding", "traceparent", "Burnish-Request-Id"}) {
    EXPECT_THAT(response.headers.at("Access-Control-Allow-Headers"), HasSubstr(name));
  }
  EXPECT_GT(std::stoi(response.headers.at("Access-Control-Max-Age")), 0);
  request.headers.erase("Access-Control-Request-Method");
  EXPECT_FALSE(from_page(house, request, kOrigin).headers.contains("Access-Control-Allow-Methods"));
}

}  // namespace
}  // namespace burnish
