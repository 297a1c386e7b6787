#include "server/http/report_header.h"

#include <nlohmann/json.hpp>

#include "server/service/smooth_service.h"

namespace burnish {

std::string report_header(const v1::SmoothReport& report) {
  using Json = nlohmann::ordered_json;
  Json json = Json::parse(to_json(report, true));
  const auto text = [&json] { return json.dump(-1, ' ', true, Json::error_handler_t::replace); };
  std::string header = text();
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
