#include "server/http/cors.h"

#include <algorithm>

namespace burnish {
namespace {

constexpr const char* kRequestHeaders =
    "Authorization, Content-Type, Accept, Content-Encoding, traceparent, Burnish-Request-Id, "
    "Idempotency-Key, Prefer, "
    "Range, "
    "If-Range, If-None-Match, Upload-Offset, Upload-Length, Upload-Complete, Repr-Digest";
constexpr const char* kAnswerHeaders =
    "Burnish-Report, Burnish-Request-Id, Retry-After, Allow, Location, ETag, Content-Range, Accept-Ranges, "
    "Preference-Applied, Upload-Offset, Upload-Length, Upload-Complete";
constexpr const char* kPreflightSeconds = "7200";  // no browser keeps one for longer

}  // namespace

bool Cors::allows(std::string_view origin) const {
  return !origin.empty() && std::ranges::any_of(origins_, [origin](const std::string& allowed) {
    return allowed == "*" || allowed == origin;
  });
}

void Cors::allow(const HttpRequest& request, HttpResponse& response) const {
  if (origins_.empty()) return;
  std::string& vary = response.headers["Vary"];  // for caches, whoever asks
  vary.append(vary.empty() ? "" : ", ").append("Origin");
  const std::string_view origin = request.header("Origin");
  if (!allows(origin)) return;
  response.headers["Access-Control-Allow-Origin"] = origin;
  response.headers["Access-Control-Expose-Headers"] = kAnswerHeaders;
  if (request.method != "OPTIONS" || request.header("Access-Control-Request-Method").empty()) return;
  response.headers["Access-Control-Allow-Methods"] = response.headers["Allow"];
  response.headers["Access-Control-Allow-Headers"] = kRequestHeaders;
  response.headers["Access-Control-Max-Age"] = kPreflightSeconds;
}

}  // namespace burnish
