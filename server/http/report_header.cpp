#include "server/http/report_header.h"

#include <algorithm>
#include <string_view>

#include <nlohmann/json.hpp>

#include "server/service/smooth_service.h"

namespace burnish {
namespace {

bool is_plain_ascii(std::string_view text) {
  return std::ranges::all_of(text, [](char c) { return c >= ' ' && c <= '~'; });
}

}  // namespace

std::string report_header(const v1::SmoothReport& report) {
  using Json = nlohmann::ordered_json;
  std::string header = to_json(report, true);
  if (header.size() <= kLongestReportHeader && is_plain_ascii(header)) return header;
  Json json = Json::parse(header);
  const auto text = [&json] { return json.dump(-1, ' ', true, Json::error_handler_t::replace); };
  header = text();
  while (header.size() > kLongestReportHeader && !json["warnings"].empty()) {
    json["warnings"].erase(json["warnings"].size() - 1);
    header = text();
  }
  if (header.size() > kLongestReportHeader) {
    json.erase("parameters");
    header = text();
  }
  return header;
}

}  // namespace burnish
