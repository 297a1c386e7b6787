#include "server/http/openapi.h"

#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "burnish/v1/smoothing.pb.h"
#include "core/smooth/registry.h"
#include "server/http/routes.h"
#include "server/status_map.h"
#include "tests/server/gateway_house.h"
#include "tests/support/shapes.h"

namespace burnish {
namespace {

using nlohmann::json;
using testing::GatewayHouse;

const json& document() {
  static const json kDocument = json::parse(openapi_document({}));
  return kDocument;
}

const json& schema(const std::string& name) { return document().at("components").at("schemas").at(name); }

/// Follows one "$ref".
const json& resolve(const json& value) {
  return value.contains("$ref")
             ? document().at(json::json_pointer(value["$ref"].get<std::string>().substr(1)))
             : value;
}

void each_reference(const json& value, const std::function<void(const std::string&)>& visit) {
  for (const auto& [name, member] : value.items()) {
    if (name == "$ref") visit(member.get<std::string>());
    if (member.is_structured()) each_reference(member, visit);
  }
}

TEST(OpenApi, DescribesEveryRouteWithEveryVerb) {
  EXPECT_EQ(document()["paths"].size(), kRoutes.size());
  for (const Route& route : kRoutes) {
    std::string verbs(route.verbs);
    const json& item = document().at("paths").at(std::string(route.path));
    std::size_t count = 0;
    for (const std::string verb : {"GET", "HEAD", "POST", "PATCH", "DELETE", "OPTIONS"}) {
      if (verbs.find(verb) == std::string::npos) continue;
      ++count;
      std::string lower = verb;
      std::ranges::transform(lower, lower.begin(), [](unsigned char c) { return std::tolower(c); });
      EXPECT_TRUE(item.contains(lower)) << route.path << verb;
    }
    EXPECT_EQ(item.size(), count) << route.path;
  }
}

TEST(OpenApi, NamesEveryCauseUnderItsStatus) {
  for (const Cause cause : all_causes()) {
    const StatusRow& row = status_of(cause);
    const std::string code(cause_code(cause));
    const bool clients = !comes_from_servers(cause);
    const json& codes = schema("Problem")["properties"]["code"]["enum"];
    EXPECT_EQ(std::ranges::count(codes, json(code)), clients ? 0 : 1) << code;
    if (clients) continue;
    const bool routing = cause == Cause::NotFound || cause == Cause::MethodNotAllowed;
    const std::string status = routing ? "4XX" : std::to_string(row.http_status);
    for (const char* path : {"/v1/smooth", "/v1/compare"}) {
      const json& response = resolve(document()["paths"][path]["post"]["responses"].at(status));
      EXPECT_NE(response["description"].get<std::string>().find('`' + code + '`'), std::string::npos) << code;
    }
  }
}

TEST(OpenApi, RefersOnlyToWhatIsThereAndUsesAllOfIt) {
  std::set<std::string> used;
  each_reference(document(), [&](const std::string& name) {
    used.insert(name);
    ASSERT_EQ(name.substr(0, 2), "#/") << name;
    EXPECT_TRUE(document().contains(json::json_pointer(name.substr(1)))) << name;
  });
  for (const auto& [kind, entries] : document()["components"].items()) {
    for (const auto& [name, entry] : entries.items()) {
      EXPECT_TRUE(used.contains("#/components/" + kind + "/" + name)) << kind << ' ' << name;
    }
  }
}

TEST(OpenApi, TakesLimitsAndMethodsFromTheServer) {
  const json own = json::parse(openapi_document({.mesh = {.max_bytes = 12'345}, .max_iterations = 77}));
  EXPECT_NE(own["paths"]["/v1/smooth"]["post"]["description"].get<std::string>().find("12345 bytes"),
            std::string::npos);
  EXPECT_EQ(own["components"]["schemas"]["SmoothOptions"]["properties"]["iterations"]["maximum"], 77);
  EXPECT_EQ(schema("DracoOptions")["properties"]["positionBits"]["maximum"], 30);
  const json& options = schema("SmoothOptions")["properties"];
  for (const Method& method : methods()) {
    EXPECT_EQ(std::ranges::count(options["method"]["enum"], json(method.name)), 1);
    for (const ParameterSpec& spec : method.parameters) {
      EXPECT_TRUE(options["parameters"]["properties"].contains(spec.name)) << spec.name;
      const json& parameters = document()["paths"]["/v1/smooth"]["post"]["parameters"];
      EXPECT_EQ(
          std::ranges::count_if(parameters, [&](const json& p) { return resolve(p)["name"] == spec.name; }),
          1)
          << spec.name;
    }
  }
}

TEST(OpenApi, SaysHowToPin) {
  const json& pinned = resolve(schema("SmoothOptions")["properties"]["pinned"]);
  EXPECT_EQ(pinned["additionalProperties"], false);
  EXPECT_EQ(pinned["properties"]["vertices"]["items"]["type"], "integer");
  EXPECT_EQ(pinned["properties"]["group"]["type"], "string");
  std::map<std::string, json> query;
  for (const json& each : document()["paths"]["/v1/smooth"]["post"]["parameters"]) {
    query[resolve(each)["name"].get<std::string>()] = resolve(each);
  }
  EXPECT_EQ(query.at("pinned_vertices")["schema"]["type"], "array");
  EXPECT_EQ(query.at("pinned_vertices")["explode"], false) << "commas, not repetition";
  EXPECT_EQ(query.at("pinned_group")["schema"]["type"], "string");
  EXPECT_EQ(query.at("pinned_attribute")["schema"]["type"], "string");
  EXPECT_TRUE(schema("SmoothReport")["properties"].contains("pinnedVertices"));
}

TEST(OpenApi, SaysHowNoiseIsReported) {
  const json& noise = resolve(schema("SmoothReport")["properties"]["noise"]);
  EXPECT_EQ(noise["properties"]["sigmaOverEdge"]["type"], "number");
  EXPECT_EQ(noise["properties"]["kind"]["type"], "string");
}

TEST(OpenApi, RequiresWhatAnswersAlwaysHold) {
  GatewayHouse house;
  HttpRequest request = testing::smooth_request(testing::to_obj(testing::sphere(1)), {{"iterations", "1"}});
  request.headers["Accept"] = "application/json";
  const json report = json::parse(house.handle(request).body)["report"];
  for (const json& name : schema("SmoothReport")["required"]) EXPECT_TRUE(report.contains(name)) << name;
  for (const auto& [name, value] : report.items())
    EXPECT_TRUE(schema("SmoothReport")["properties"].contains(name)) << name;
  for (const json& name : schema("StageTimings")["required"])
    EXPECT_TRUE(report["timings"].contains(name)) << name;
}

TEST(OpenApi, IsServed) {
  GatewayHouse house;
  const HttpResponse response = house.get("/openapi.json");
  EXPECT_EQ(response.status, 200);
  EXPECT_EQ(response.headers.at("Content-Type"), "application/json");
  EXPECT_EQ(json::parse(response.body)["openapi"], "3.1.0");
}

}  // namespace
}  // namespace burnish
