#include "server/http/media_type.h"

#include <algorithm>
#include <array>
#include <cctype>

#include "server/http/header_value.h"

namespace burnish {
namespace {

/// 3 for the type itself, 2 for "model/*", 1 for "*/*", 0 for another type.
int closeness(std::string_view range, std::string_view type) {
  if (range == type) return 3;
  if (range == "*/*") return 1;
  return range.ends_with("/*") && type.starts_with(range.substr(0, range.size() - 1)) ? 2 : 0;
}

double quality_for(std::string_view type, std::string_view accept) {
  int closest = 0;
  double quality = 0;
  for (const std::string_view range : split_value(accept, ',')) {
    const int close = closeness(media_type(range), type);
    if (close <= closest) continue;
    closest = close;
    quality = quality_of(range);
  }
  return quality;
}

}  // namespace

std::string_view media_type_of(Format format) { return traits_of(format).media_type; }

std::string media_type(std::string_view content_type) {
  std::string type(split_value(content_type, ';').front());
  std::ranges::transform(type, type.begin(), [](unsigned char c) { return std::tolower(c); });
  return type;
}

bool is_form(std::string_view content_type) { return media_type(content_type) == "multipart/form-data"; }

Result<std::optional<Format>> mesh_format(std::string_view content_type) {
  const std::string type = media_type(content_type);
  if (const auto format = format_of_media_type(type)) return format;
  // The last is what curl --data-binary sends unless told otherwise.
  constexpr std::array<std::string_view, 4> kByContent{"", kAnyBytesType, "text/plain",
                                                       "application/x-www-form-urlencoded"};
  if (std::ranges::find(kByContent, type) != kByContent.end()) return std::optional<Format>();
  return Error{Cause::UnsupportedFormat, "Content-Type '" + type + "' is not a mesh; send " +
                                             list_of_media_types() +
                                             ", or application/octet-stream for any of them"};
}

std::optional<std::string_view> best_offer(std::string_view accept,
                                           std::span<const std::string_view> offers) {
  if (accept.empty()) return offers.front();
  std::optional<std::string_view> best;
  double most = 0;
  for (const std::string_view offer : offers) {
    const double quality = quality_for(offer, accept);
    if (quality <= most) continue;
    most = quality;
    best = offer;
  }
  return best;
}

}  // namespace burnish
