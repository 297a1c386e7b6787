#include "server/http/answer_encoding.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "server/http/gzip.h"
#include "server/http/media_type.h"

namespace burnish {
namespace {

constexpr std::size_t kLeastBytes = 1 << 10;

/// Draco is packed already; of formats that may be text, binary files are sent as they are.
bool is_text(const HttpResponse& response) {
  const auto found = response.headers.find("Content-Type");
  const std::string type = found == response.headers.end() ? "" : media_type(found->second);
  if (const auto format = format_of_media_type(type))
    return traits_of(*format).may_be_text && looks_like_text(response.body);
  constexpr std::array kTypes{"application/json", "application/problem+json"};
  return type.starts_with("text/") || std::ranges::find(kTypes, type) != kTypes.end();
}

}  // namespace

bool encode_answer(HttpResponse& response, std::string_view accept_encoding,
                   const std::function<bool()>& give_up) {
  if (response.body.size() < kLeastBytes || !is_text(response)) return true;
  std::string& vary = response.headers["Vary"];
  vary.append(vary.empty() ? "" : ", ").append("Accept-Encoding");
  if (!accepts_gzip(accept_encoding)) return true;
  auto compressed = gzip(response.body, give_up);
  if (!compressed) return false;
  response.body = *std::move(compressed);
  response.headers["Content-Encoding"] = "gzip";
  return true;
}

}  // namespace burnish
