#include "server/http/problem.h"

#include <nlohmann/json.hpp>

#include "server/status_map.h"

namespace burnish {
namespace {

using Json = nlohmann::ordered_json;

HttpResponse respond(int status, std::string_view code, std::string_view title, std::string_view detail,
                     std::string_view request_id, std::string_view field) {
  Json json = {{"type", "urn:burnish:problem:" + std::string(code)},
               {"title", title},
               {"status", status},
               {"detail", detail},
               {"code", code},
               {"requestId", request_id}};
  if (!field.empty()) json["field"] = field;
  // Foreign names may hold bytes that are not UTF-8; dump() would throw.
  return {.status = status,
          .headers = {{"Content-Type", "application/problem+json"},
                      {"Burnish-Request-Id", std::string(request_id)}},
          .body = json.dump(-1, ' ', true, Json::error_handler_t::replace) + "\n"};
}

}  // namespace

HttpResponse problem(const Error& error, std::string_view request_id) {
  const StatusRow& row = status_of(error.cause);
  HttpResponse response =
      respond(row.http_status, cause_code(error.cause), row.title, error.message, request_id, error.field);
  if (error.cause == Cause::QueueFull || error.cause == Cause::ShuttingDown) {
    response.headers["Retry-After"] = "1";
  }
  return response;
}

HttpResponse bad_request(int status, std::string_view request_id) {
  return respond(status, "bad_request", "Bad request", "the server cannot understand this HTTP request",
                 request_id, "");
}

}  // namespace burnish
