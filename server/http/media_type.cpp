#include "server/http/media_type.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <vector>

namespace burnish {
namespace {

std::string_view trim(std::string_view text) {
  constexpr std::string_view kBlanks = " \t";
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> pieces;
  while (true) {
    const std::size_t end = text.find(separator);
    pieces.push_back(trim(text.substr(0, end)));
    if (end == std::string_view::npos) return pieces;
    text.remove_prefix(end + 1);
  }
}

/// "q=0.5" among the parameters of a range; 1 when there is none, 0 when it cannot be read.
double quality_of(const std::vector<std::string_view>& range) {
  for (const std::string_view parameter : range) {
    if (!parameter.starts_with("q=") && !parameter.starts_with("Q=")) continue;
    double quality = 0;
    const char* const end = parameter.data() + parameter.size();
    const auto [stop, failure] = std::from_chars(parameter.data() + 2, end, quality);
    return failure == std::errc() && stop == end && quality <= 1 ? quality : 0;
  }
  return 1;
}

/// 3 for the type itself, 2 for "model/*", 1 for "*/*", 0 for another type.
int closeness(std::string_view range, std::string_view type) {
  if (range == type) return 3;
  if (range == "*/*") return 1;
  return range.ends_with("/*") && type.starts_with(range.substr(0, range.size() - 1)) ? 2 : 0;
}

double quality_of(std::string_view type, std::string_view accept) {
  int closest = 0;
  double quality = 0;
  for (const std::string_view item : split(accept, ',')) {
    const auto range = split(item, ';');
    const int close = closeness(media_type(range.front()), type);
    if (close <= closest) continue;
    closest = close;
    quality = quality_of(range);
  }
  return quality;
}

}  // namespace

std::string_view media_type_of(Format format) {
  return format == Format::Obj ? "model/obj" : "model/vnd.draco";
}

std::string media_type(std::string_view content_type) {
  std::string type(trim(content_type.substr(0, content_type.find(';'))));
  std::ranges::transform(type, type.begin(), [](unsigned char c) { return std::tolower(c); });
  return type;
}

bool is_form(std::string_view content_type) { return media_type(content_type) == "multipart/form-data"; }

Result<std::optional<Format>> mesh_format(std::string_view content_type) {
  const std::string type = media_type(content_type);
  for (const Format format : {Format::Obj, Format::Draco}) {
    if (type == media_type_of(format)) return std::optional(format);
  }
  // The last is what curl --data-binary sends unless told otherwise.
  constexpr std::array<std::string_view, 4> kByContent{"", kAnyBytesType, "text/plain",
                                                       "application/x-www-form-urlencoded"};
  if (std::ranges::find(kByContent, type) != kByContent.end()) return std::optional<Format>();
  return Error{Cause::UnsupportedFormat, "Content-Type '" + type +
                                             "' is not a mesh; send model/obj, model/vnd.draco or "
                                             "application/octet-stream"};
}

std::optional<std::string_view> best_offer(std::string_view accept,
                                           std::span<const std::string_view> offers) {
  if (trim(accept).empty()) return offers.front();
  std::optional<std::string_view> best;
  double most = 0;
  for (const std::string_view offer : offers) {
    const double quality = quality_of(offer, accept);
    if (quality <= most) continue;
    most = quality;
    best = offer;
  }
  return best;
}

}  // namespace burnish
