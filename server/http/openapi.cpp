#include "server/http/openapi.h"

#include <algorithm>
#include <cctype>

#include <nlohmann/json.hpp>

#include "core/smooth/registry.h"
#include "server/http/media_type.h"
#include "server/http/openapi_components.h"
#include "server/http/openapi_kept.h"
#include "server/http/openapi_schemas.h"
#include "server/http/routes.h"
#include "server/http/smooth_query.h"
#include "server/service/smooth_service.h"

namespace burnish {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kTextType = "text/plain";
constexpr std::uint32_t kMostVertex = 0xffffffff;

/// A file as it is: OpenAPI 3.1 says so by saying nothing.
Json file() { return {{"schema", Json::object()}}; }

Json names_of_formats() {
  Json names = Json::array();
  for (const FormatTraits& each : formats()) names.push_back(each.name);
  return names;
}

Json common_parameters() {
  return {openapi_reference("parameters", "RequestId"), openapi_reference("parameters", "traceparent")};
}

Json smooth_parameters(const RequestLimits& limits) {
  Json list = common_parameters();
  list.push_back(openapi_reference("parameters", "timeout_ms"));
  Json names = Json::array();
  for (const Method& method : methods()) names.push_back(method.name);
  list.push_back(query_parameter("method", {{"type", "string"}, {"enum", names}, {"default", names[0]}},
                                 "What to smooth with; GET /v1/methods describes each."));
  const Json of_methods = method_parameter_schemas(limits);
  for (const auto& [name, schema] : of_methods.items()) {
    list.push_back(query_parameter(name, schema, schema["description"]));
  }
  list.push_back(query_parameter("output", {{"type", "string"}, {"enum", names_of_formats()}},
                                 "Format of the result; default: the mesh's."));
  list.push_back(query_parameter("draco_method",
                                 {{"type", "string"}, {"enum", {"sequential", "edgebreaker"}}},
                                 "How Draco stores connectivity; sequential keeps the order."));
  for (const DracoNumber& number : kDracoNumbers) {
    list.push_back(query_parameter(number.name,
                                   {{"type", "integer"}, {"minimum", 0}, {"maximum", number.most}},
                                   "Of Draco results, as in SmoothOptions.output.draco."));
  }
  const Json name = {{"type", "string"}, {"minLength", 1}};
  list.push_back(
      query_parameter("pinned_group", name,
                      "Vertices of this group of an OBJ, or mesh or node of a GLB, stay where they are."));
  list.push_back(query_parameter("pinned_attribute", name,
                                 "Points where this Draco attribute is not 0 stay where they are."));
  Json vertices =
      query_parameter("pinned_vertices",
                      {{"type", "array"},
                       {"minItems", 1},
                       {"items", {{"type", "integer"}, {"minimum", 0}, {"maximum", kMostVertex}}}},
                      "Vertices that stay where they are, counted from 0, with commas between.");
  vertices["style"] = "form";
  vertices["explode"] = false;
  list.push_back(std::move(vertices));
  return list;
}

/// What every operation on meshes may answer beside its success.
void add_problems(Json& responses) {
  for (const int status : problem_statuses_of_work()) {
    responses[std::to_string(status)] = problem_reference(status);
  }
  responses["4XX"] = other_problem_reference();
}

/// What a part with a mesh may say of itself.
Json part_types() {
  std::string list;
  for (const FormatTraits& each : formats()) list.append(each.media_type).append(", ");
  return {{"contentType", list + std::string(kAnyBytesType)}};
}

Json form_part(const std::string& text) { return {{"description", text}}; }

Json form(Json parts, Json required, Json encoding) {
  return {{"schema",
           {{"type", "object"},
            {"properties", std::move(parts)},
            {"required", std::move(required)},
            {"additionalProperties", false}}},
          {"encoding", std::move(encoding)}};
}

Json smooth_form() {
  const Json mesh = part_types();
  return form({{"mesh", form_part("The mesh file.")},
               {"reference", form_part("A mesh to measure the errors against.")},
               {"options", schema_reference("SmoothOptions")}},
              {"mesh"}, {{"mesh", mesh}, {"reference", mesh}, {"options", {{"contentType", kJsonType}}}});
}

Json compare_form() {
  const Json mesh = part_types();
  return form(
      {{"reference", form_part("The mesh to measure against.")}, {"mesh", form_part("The mesh to measure.")}},
      {"reference", "mesh"}, {{"reference", mesh}, {"mesh", mesh}});
}

Json smooth_operation(const RequestLimits& limits) {
  Json success_headers = openapi_answer_headers();
  success_headers["Burnish-Report"] = openapi_reference("headers", "Burnish-Report");
  Json content = openapi_mesh_content();
  content[std::string(kAnyBytesType)] = file();
  content[std::string(kJsonType)] = {{"schema", schema_reference("SmoothResponse")}};
  Json responses = {{"200",
                     {{"description",
                       "The smoothed mesh: same order, same attributes. With `Accept: application/json` a "
                       "SmoothResponse, the report inside instead of in a header."},
                      {"headers", std::move(success_headers)},
                      {"content", std::move(content)}}}};
  add_problems(responses);
  Json body = openapi_mesh_content();
  body[std::string(kAnyBytesType)] = file();
  body["multipart/form-data"] = smooth_form();
  return {{"operationId", "smooth"},
          {"summary", "Smooth a mesh"},
          {"description",
           "The mesh is the raw body, with options in the query, or a part of a form. A form that has the "
           "part options takes none but timeout_ms from the query. Each mesh has at most " +
               std::to_string(limits.mesh.max_bytes) + " bytes, " + std::to_string(limits.mesh.max_vertices) +
               " vertices and " + std::to_string(limits.mesh.max_triangles) +
               " triangles. The body may come with `Content-Encoding: gzip`."},
          {"parameters", smooth_parameters(limits)},
          {"requestBody", {{"required", true}, {"content", std::move(body)}}},
          {"responses", std::move(responses)}};
}

Json compare_operation() {
  Json responses = {{"200",
                     {{"description", "The error table of the mesh against the reference."},
                      {"headers", openapi_answer_headers()},
                      {"content", openapi_content(kJsonType, schema_reference("CompareResponse"))}}}};
  add_problems(responses);
  Json list = common_parameters();
  list.push_back(openapi_reference("parameters", "timeout_ms"));
  return {{"operationId", "compare"},
          {"summary", "Measure one mesh against another"},
          {"parameters", std::move(list)},
          {"requestBody", {{"required", true}, {"content", {{"multipart/form-data", compare_form()}}}}},
          {"responses", std::move(responses)}};
}

struct Reading {
  const char *name, *summary;
  std::string_view type;
  Json schema;
};

Reading reading_of(Endpoint endpoint) {
  const Json text = {{"type", "string"}};
  switch (endpoint) {
    case Endpoint::Methods:
      return {"Methods", "Every method with its parameters; the first is the default", kJsonType,
              schema_reference("ListMethodsResponse")};
    case Endpoint::OpenApi:
      return {"OpenApi", "This document", kJsonType, {{"type", "object"}}};
    case Endpoint::Ready:
      return {"Readiness", "Whether the server takes work now", kTextType, text};
    case Endpoint::Metrics:
      return {"Metrics", "Metrics in Prometheus' text format", kTextType, text};
    default:
      return {"Liveness", "Whether the process lives", kTextType, text};
  }
}

Json read_operation(const Route& route, const std::string& verb) {
  const Reading reading = reading_of(route.endpoint);
  Json success = {{"description", reading.summary}, {"headers", openapi_answer_headers()}};
  if (verb == "get") success["content"] = openapi_content(reading.type, reading.schema);
  Json responses = {{"200", std::move(success)}};
  if (route.endpoint == Endpoint::Ready) responses["503"] = problem_reference(503);
  responses["4XX"] = other_problem_reference();
  return {{"operationId", verb + reading.name},
          {"summary", verb == "get" ? reading.summary : std::string(reading.summary) + ": the head alone"},
          {"parameters", common_parameters()},
          {"responses", std::move(responses)}};
}

Json options_operation(const std::string& name) {
  Json success_headers = openapi_answer_headers();
  success_headers["Allow"] = openapi_reference("headers", "Allow");
  return {{"operationId", "options" + name},
          {"summary", "The verbs of this path; also answers browsers' CORS preflights"},
          {"responses",
           {{"204", {{"description", "See the header Allow"}, {"headers", std::move(success_headers)}}},
            {"4XX", other_problem_reference()}}}};
}

/// A job is submitted with what POST /v1/smooth takes, and a form needs no mesh then.
Json kept_item(const Route& route, const RequestLimits& limits) {
  Json item = Json::object();
  for (const std::string verb : {"get", "head", "post", "patch", "delete"}) {
    std::string upper = verb;
    std::ranges::transform(upper, upper.begin(),
                           [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    if (!route.allows(upper)) continue;
    Json submission = verb == "post" ? smooth_operation(limits) : Json::object();
    if (verb == "post") {
      submission["requestBody"]["required"] = false;
      Json& schema = submission["requestBody"]["content"]["multipart/form-data"]["schema"];
      schema.erase("required");
      for (const char* word : {"mesh_sha256", "reference_sha256", "priority"})
        schema["properties"][word] = {{"type", "string"}};
    }
    item[verb] = kept_operation(route, verb, std::move(submission));
  }
  item["options"] = options_operation(kept_name(route.endpoint));
  if (route.path.find("{id}") != std::string_view::npos)
    item["options"]["parameters"] = {openapi_reference("parameters", "id")};
  return item;
}

Json path_item(const Route& route, const RequestLimits& limits) {
  switch (route.endpoint) {
    case Endpoint::Smooth:
      return {{"post", smooth_operation(limits)}, {"options", options_operation("Smooth")}};
    case Endpoint::Compare:
      return {{"post", compare_operation()}, {"options", options_operation("Compare")}};
    default:
      if (route.is_kept()) return kept_item(route, limits);
      return {{"get", read_operation(route, "get")},
              {"head", read_operation(route, "head")},
              {"options", options_operation(reading_of(route.endpoint).name)}};
  }
}

}  // namespace

std::string openapi_document(const RequestLimits& limits) {
  Json paths = Json::object();
  for (const Route& route : kRoutes) paths[std::string(route.path)] = path_item(route, limits);
  const Json document = {
      {"openapi", "3.1.0"},
      {"info",
       {{"title", "Burnish"},
        {"version", version()},
        {"summary", "Smooths triangle meshes without destroying their features"},
        {"description",
         "Another path answers 404, another verb 405. Answers are compressed for callers that say so in "
         "Accept-Encoding. JSON is the protobuf mapping of the messages in "
         "proto/burnish/v1/smoothing.proto, which gives the unit of every field."},
        {"license", {{"name", "Apache-2.0"}, {"identifier", "Apache-2.0"}}}}},
      {"servers", {{{"url", "/"}}}},
      {"security", Json::array()},
      {"paths", std::move(paths)},
      {"components", openapi_components(limits)}};
  return document.dump(2) + "\n";
}

}  // namespace burnish
