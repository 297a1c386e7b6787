#include "server/http/openapi_components.h"

#include <map>

#include "core/run/error.h"
#include "server/http/media_type.h"
#include "server/http/openapi_schemas.h"
#include "server/http/smooth_query.h"
#include "server/status_map.h"

namespace burnish {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kOtherProblem = "OtherProblem";

std::string response_name(int status) { return "Problem" + std::to_string(status); }

/// For another path or verb than the one that an operation describes.
bool is_routing(Cause cause) { return cause == Cause::NotFound || cause == Cause::MethodNotAllowed; }

/// One response per HTTP status, naming the codes that share it; another for all that is no operation's own.
Json problem_responses() {
  std::map<std::string, std::string> texts = {
      {kOtherProblem, "Bad request, by another status: HTTP is broken"}};
  for (const Cause cause : all_causes()) {
    if (!comes_from_servers(cause)) continue;
    const StatusRow& row = status_of(cause);
    std::string& text = texts[is_routing(cause) ? kOtherProblem : response_name(row.http_status)];
    if (!text.empty()) text += ", ";
    text += row.title + (" (`" + std::string(cause_code(cause)) + "`)");
  }
  Json responses = Json::object();
  for (const auto& [name, text] : texts) {
    responses[name] = {{"description", text},
                       {"headers", openapi_answer_headers()},
                       {"content", openapi_content("application/problem+json", schema_reference("Problem"))}};
    if (name == response_name(429) || name == response_name(503)) {
      responses[name]["headers"]["Retry-After"] = openapi_reference("headers", "Retry-After");
    }
  }
  return responses;
}

Json headers() {
  const Json text = {{"type", "string"}}, count = {{"type", "integer"}, {"minimum", 0}};
  return {{"Burnish-Request-Id",
           {{"description", "Identifies the request in the server's log: the caller's own, or a new one."},
            {"schema", {{"type", "string"}, {"pattern", "^[A-Za-z0-9._-]{1,64}$"}}}}},
          {"Burnish-Report",
           {{"description",
             "SmoothReport as compact ASCII JSON of at most 3 KB; of many warnings the last are left out."},
            {"content", openapi_content(kJsonType, schema_reference("SmoothReport"))}}},
          {"Retry-After",
           {{"description", "Seconds after which to try again."},
            {"schema", {{"type", "integer"}, {"minimum", 1}}}}},
          {"Allow", {{"description", "The verbs of this path."}, {"schema", text}}},
          {"Location", {{"description", "Where what was made, or what is wanted, is."}, {"schema", text}}},
          {"Preference-Applied", {{"description", "wait=N, when it was asked for."}, {"schema", text}}},
          {"ETag", {{"description", "The SHA-256 of the bytes, in quotes."}, {"schema", text}}},
          {"Accept-Ranges", {{"description", "bytes."}, {"schema", text}}},
          {"Content-Range", {{"description", "Which bytes of how many."}, {"schema", text}}},
          {"Upload-Offset", {{"description", "Bytes that there are."}, {"schema", count}}},
          {"Upload-Length",
           {{"description", "Bytes that there will be; left out: not known."}, {"schema", count}}},
          {"Upload-Complete",
           {{"description", "Whether all bytes are there."},
            {"schema", {{"type", "string"}, {"enum", {"?0", "?1"}}}}}}};
}

Json header_parameter(const std::string& name, const std::string& text, const std::string& pattern) {
  return {{"name", name},
          {"in", "header"},
          {"description", text},
          {"schema", {{"type", "string"}, {"pattern", pattern}}}};
}

Json kept_parameters() {
  const Json digest = {{"type", "string"}, {"pattern", "^[0-9A-Fa-f]{64}$"}};
  Json id = header_parameter("id", "Of the job or the upload, as the server gave it.", "^[0-9a-f]+$");
  id["in"] = "path";
  id["required"] = true;
  return {
      {"id", std::move(id)},
      {"mesh_sha256", query_parameter("mesh_sha256", digest, "A mesh that the caller has uploaded or used.")},
      {"reference_sha256", query_parameter("reference_sha256", digest, "Likewise, to measure against.")},
      {"priority", query_parameter("priority", {{"type", "string"}, {"enum", {"normal", "low"}}},
                                   "Low: after all normal ones.")},
      {"page_size", query_parameter("page_size", {{"type", "integer"}, {"minimum", 1}, {"maximum", 1000}},
                                    "At most so many; default: 100.")},
      {"page_token",
       query_parameter("page_token", {{"type", "string"}}, "nextPageToken of the page before.")},
      {"IdempotencyKey",
       header_parameter("Idempotency-Key", "The same key and request again give the same job.",
                        "^[!-~]{1,128}$")},
      {"Prefer", header_parameter("Prefer", "wait=N: seconds to wait for the end, at most 60.", "^.*$")},
      {"Range", header_parameter("Range", "One range of bytes.", "^bytes=[0-9]*-[0-9]*$")},
      {"UploadLength", header_parameter("Upload-Length", "Bytes that there will be.", "^[0-9]+$")},
      {"UploadOffset", header_parameter("Upload-Offset", "Bytes that there are.", "^[0-9]+$")},
      {"UploadComplete",
       header_parameter("Upload-Complete", "?1: nothing follows these bytes.", "^[?][01]$")},
      {"ReprDigest", header_parameter("Repr-Digest", "sha-256=:BASE64: of all bytes.", "^.*$")}};
}

Json common_parameters() {
  return {
      {"timeout_ms",
       query_parameter("timeout_ms", {{"type", "integer"}, {"minimum", 1}, {"maximum", kLongestTimeoutMs}},
                       "The job's deadline, in milliseconds from when the request has come whole.")},
      {"RequestId",
       header_parameter("Burnish-Request-Id", "An id to use for this request.", "^[A-Za-z0-9._-]{1,64}$")},
      {"traceparent", header_parameter("traceparent", "W3C Trace Context; the log names its trace.",
                                       "^[0-9a-f]{2}-[0-9a-f]{32}-[0-9a-f]{16}-[0-9a-f]{2}")}};
}

Json parameters() {
  Json all = kept_parameters();
  all.update(common_parameters());
  return all;
}

}  // namespace

Json openapi_reference(const std::string& kind, const std::string& name) {
  return {{"$ref", "#/components/" + kind + "/" + name}};
}

Json openapi_content(std::string_view type, Json schema) { return {{type, {{"schema", std::move(schema)}}}}; }

Json openapi_mesh_content() {
  Json content = Json::object();
  for (const FormatTraits& each : formats())
    content[std::string(each.media_type)] = {{"schema", Json::object()}};
  return content;
}

Json query_parameter(const std::string& name, Json schema, const std::string& text) {
  return {{"name", name}, {"in", "query"}, {"description", text}, {"schema", std::move(schema)}};
}

Json openapi_answer_headers() {
  return {{"Burnish-Request-Id", openapi_reference("headers", "Burnish-Request-Id")}};
}

Json problem_reference(int status) { return openapi_reference("responses", response_name(status)); }

Json other_problem_reference() { return openapi_reference("responses", kOtherProblem); }

std::set<int> problem_statuses_of_work() {
  std::set<int> statuses;
  for (const Cause cause : all_causes()) {
    if (comes_from_servers(cause) && !is_routing(cause)) statuses.insert(status_of(cause).http_status);
  }
  return statuses;
}

Json openapi_components(const RequestLimits& limits) {
  return {{"schemas", openapi_schemas(limits)},
          {"parameters", parameters()},
          {"headers", headers()},
          {"responses", problem_responses()}};
}

}  // namespace burnish
