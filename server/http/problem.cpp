#include "server/http/problem.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "server/status_map.h"

namespace burnish {
namespace {

bool may_help_to_retry(Cause cause) {
  return cause == Cause::QueueFull || cause == Cause::MemoryFull || cause == Cause::ShuttingDown;
}

std::string whole_seconds(std::chrono::milliseconds time) {
  return std::to_string(std::max<std::int64_t>(1, std::chrono::ceil<std::chrono::seconds>(time).count()));
}

}  // namespace

HttpResponse problem(const Error& error, std::string_view request_id, std::optional<int> status) {
  using Json = nlohmann::ordered_json;
  const StatusRow& row = status_of(error.cause);
  const std::string code(cause_code(error.cause));
  HttpResponse response{.status = status.value_or(row.http_status),
                        .headers = {{"Content-Type", "application/problem+json"}}};
  Json json = {{"type", "urn:burnish:problem:" + code},
               {"title", row.title},
               {"status", response.status},
               {"detail", error.message},
               {"code", code},
               {"requestId", request_id}};
  if (!error.field.empty()) json["field"] = error.field;
  // Foreign names may hold bytes that are not UTF-8; dump() would throw.
  response.body = json.dump(-1, ' ', true, Json::error_handler_t::replace) + "\n";
  if (may_help_to_retry(error.cause) || error.retry_after.count() > 0)
    response.headers["Retry-After"] = whole_seconds(error.retry_after);
  return response;
}

}  // namespace burnish
