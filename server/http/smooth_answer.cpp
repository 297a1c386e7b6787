#include "server/http/smooth_answer.h"

#include <vector>

#include <absl/strings/escaping.h>

#include "server/http/media_type.h"
#include "server/http/report_header.h"

namespace burnish {
namespace {

/// A multiple of 3, so that only the last piece is padded.
constexpr std::size_t kPiece = 3 << 16;

/// By hand, because a mesh is no string that a JSON library should hold, copy and escape.
std::string to_smooth_response_json(const SmoothResult& result) {
  const std::string report = to_json(result.report, true);
  const absl::string_view mesh = result.mesh;  // Debian's absl has a type of its own
  std::string json;
  json.reserve((mesh.size() / 3 + 1) * 4 + report.size() + 100);
  json += R"({"mesh":")";
  for (std::size_t at = 0; at < mesh.size(); at += kPiece)
    json += absl::Base64Escape(mesh.substr(at, kPiece));
  json += R"(","format":")" + v1::MeshFormat_Name(to_proto(result.format));
  json += R"(","report":)" + report + "}\n";
  return json;
}

}  // namespace

Result<std::string_view> choose_smooth_answer(std::string_view accept, std::optional<Format> format) {
  std::vector<std::string_view> offers;
  for (const FormatTraits& each : formats()) {
    if (each.format == format.value_or(each.format)) offers.push_back(each.media_type);
  }
  offers.insert(offers.end(), {kJsonType, kAnyBytesType});
  if (const auto best = best_offer(accept, offers)) return *best;
  std::string list;
  for (const std::string_view offer : offers) list += (list.empty() ? "" : ", ") + std::string(offer);
  return Error{Cause::NotAcceptable, "the answer can be " + list + "; the Accept header takes none of them"};
}

std::optional<Format> result_format(const SmoothJob& job) {
  if (const auto asked = from_proto(job.options.output().format())) return asked;
  return job.format ? job.format : detect_format(job.mesh);
}

HttpResponse smooth_answer(SmoothResult result, std::string_view media_type) {
  if (media_type == kJsonType) {
    return {.headers = {{"Content-Type", std::string(kJsonType)}}, .body = to_smooth_response_json(result)};
  }
  const auto type = media_type == kAnyBytesType ? kAnyBytesType : media_type_of(result.format);
  return {.headers = {{"Content-Type", std::string(type)}, {"Burnish-Report", report_header(result.report)}},
          .body = std::move(result.mesh)};
}

}  // namespace burnish
