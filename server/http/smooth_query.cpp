#include "server/http/smooth_query.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <string>

#include "core/smooth/registry.h"
#include "server/service/smooth_service.h"

namespace burnish {
namespace {

constexpr std::uint32_t kLongestTimeoutMs = 24 * 60 * 60 * 1000;

Error bad_value(const std::string& name, const std::string& text, const std::string& expected) {
  return {Cause::BadOption, "query parameter '" + name + "' is '" + text + "', expected " + expected, name};
}

Result<std::uint32_t> whole_number(const std::string& name, const std::string& text, std::uint32_t least,
                                   std::uint32_t most) {
  std::uint32_t value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, failure] = std::from_chars(text.data(), end, value);
  if (failure != std::errc() || stop != end || value < least || value > most) {
    return bad_value(name, text,
                     "a whole number from " + std::to_string(least) + " to " + std::to_string(most));
  }
  return value;
}

struct DracoNumber {
  std::string_view name;
  void (v1::DracoOptions::*set)(std::uint32_t);
  std::uint32_t most;
};
constexpr std::array kDracoNumbers{
    DracoNumber{"position_bits", &v1::DracoOptions::set_position_bits, 30},
    DracoNumber{"normal_bits", &v1::DracoOptions::set_normal_bits, 30},
    DracoNumber{"texture_coordinate_bits", &v1::DracoOptions::set_texture_coordinate_bits, 30},
    DracoNumber{"color_bits", &v1::DracoOptions::set_color_bits, 30},
    DracoNumber{"generic_bits", &v1::DracoOptions::set_generic_bits, 30},
    DracoNumber{"speed", &v1::DracoOptions::set_speed, 10},
};

Result<> set_output(SmoothQuery& query, const std::string& name, const std::string& text) {
  if (text != "obj" && text != "drc") return bad_value(name, text, "obj or drc");
  query.options.mutable_output()->set_format(text == "obj" ? v1::MESH_FORMAT_OBJ : v1::MESH_FORMAT_DRACO);
  return {};
}

Result<> set_draco_method(SmoothQuery& query, const std::string& name, const std::string& text) {
  if (text != "sequential" && text != "edgebreaker")
    return bad_value(name, text, "sequential or edgebreaker");
  query.options.mutable_output()->mutable_draco()->set_method(
      text == "sequential" ? v1::DRACO_METHOD_SEQUENTIAL : v1::DRACO_METHOD_EDGEBREAKER);
  return {};
}

Result<> set_timeout(SmoothQuery& query, const std::string& name, const std::string& text) {
  const auto value = whole_number(name, text, 1, kLongestTimeoutMs);
  if (!value) return value.error();
  query.timeout = std::chrono::milliseconds(value.value());
  return {};
}

Result<> set_one(SmoothQuery& query, const std::string& name, const std::string& text) {
  if (name == "output") return set_output(query, name, text);
  if (name == "draco_method") return set_draco_method(query, name, text);
  if (name == "timeout_ms") return set_timeout(query, name, text);
  const auto* draco = std::ranges::find(kDracoNumbers, name, &DracoNumber::name);
  if (draco == kDracoNumbers.end()) return set_parameter_from_text(query.options, name, text);
  const auto value = whole_number(name, text, 0, draco->most);
  if (!value) return value.error();
  (query.options.mutable_output()->mutable_draco()->*draco->set)(value.value());
  return {};
}

Result<std::optional<Format>> body_format(const HttpRequest& request) {
  const std::string_view encoding = request.header("Content-Encoding");
  if (!encoding.empty() && encoding != "identity") {
    return Error{Cause::UnsupportedFormat,
                 "Content-Encoding '" + std::string(encoding) + "' is not supported; send the mesh as it is"};
  }
  std::string type(request.header("Content-Type"));
  type.resize(std::min(type.find(';'), type.size()));
  while (type.ends_with(' ')) type.pop_back();
  std::ranges::transform(type, type.begin(), [](unsigned char c) { return std::tolower(c); });
  if (type == "model/obj") return std::optional(Format::Obj);
  if (type == "model/vnd.draco") return std::optional(Format::Draco);
  // The last is what curl --data-binary sends unless told otherwise.
  constexpr std::array<std::string_view, 4> by_content{"", "application/octet-stream", "text/plain",
                                                       "application/x-www-form-urlencoded"};
  if (std::ranges::find(by_content, type) != by_content.end()) return std::optional<Format>();
  return Error{Cause::UnsupportedFormat, "Content-Type '" + type +
                                             "' is not a mesh; send model/obj, model/vnd.draco or "
                                             "application/octet-stream"};
}

}  // namespace

Result<SmoothQuery> parse_smooth_query(const HttpRequest& request) {
  SmoothQuery query;
  const auto format = body_format(request);
  if (!format) return format.error();
  query.format = format.value();

  if (const auto method = request.query.find("method"); method != request.query.end()) {
    query.options.set_method(method->second);  // first: it decides which other names there are
  }
  if (const auto known = find_method(query.options.method()); !known) return known.error();
  for (const auto& [name, text] : request.query) {
    if (request.query.count(name) > 1) {
      return Error{Cause::BadOption, "query parameter '" + name + "' is given more than once", name};
    }
    if (name == "method") continue;
    if (auto set = set_one(query, name, text); !set) return std::move(set).error();
  }
  return query;
}

}  // namespace burnish
