#include "server/http/smooth_query.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <limits>
#include <string_view>

#include "core/smooth/registry.h"
#include "server/service/smooth_service.h"

namespace burnish {
namespace {

constexpr const char* kTimeoutName = "timeout_ms";

Error bad_value(const std::string& name, const std::string& text, const std::string& expected) {
  return {Cause::BadOption, "query parameter '" + name + "' is '" + text + "', expected " + expected, name};
}

Error given_twice(const std::string& name) {
  return {Cause::BadOption, "query parameter '" + name + "' is given more than once", name};
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

Result<> set_output(v1::SmoothOptions& options, const std::string& name, const std::string& text) {
  const auto format = format_named(text);
  if (!format) return bad_value(name, text, list_of_format_names());
  options.mutable_output()->set_format(to_proto(*format));
  return {};
}

Result<> set_draco_method(v1::SmoothOptions& options, const std::string& name, const std::string& text) {
  if (text != "sequential" && text != "edgebreaker")
    return bad_value(name, text, "sequential or edgebreaker");
  options.mutable_output()->mutable_draco()->set_method(text == "sequential" ? v1::DRACO_METHOD_SEQUENTIAL
                                                                             : v1::DRACO_METHOD_EDGEBREAKER);
  return {};
}

Result<> pin_vertices(v1::SmoothOptions& options, const std::string& name, std::string_view list) {
  for (;;) {
    const std::size_t comma = list.find(',');
    const auto vertex =
        whole_number(name, std::string(list.substr(0, comma)), 0, std::numeric_limits<std::uint32_t>::max());
    if (!vertex) return vertex.error();
    options.mutable_pinned()->add_vertices(*vertex);
    if (comma == std::string_view::npos) return {};
    list.remove_prefix(comma + 1);
  }
}

/// The names of every query beside those of the method.
Error unknown_name(Error error) {
  error.message += "; every query may also have method, output, draco_method";
  for (const DracoNumber& each : kDracoNumbers) error.message += std::string(", ") + each.name;
  error.message += std::string(", pinned_vertices, pinned_group, pinned_attribute, ") + kTimeoutName;
  return error;
}

Result<> set_one(v1::SmoothOptions& options, const std::string& name, const std::string& text) {
  if (name == "pinned_vertices") return pin_vertices(options, name, text);
  if (name == "pinned_group" || name == "pinned_attribute") {
    if (text.empty()) return bad_value(name, text, "a name");
    v1::PinnedVertices& pinned = *options.mutable_pinned();
    (name == "pinned_group" ? pinned.mutable_group() : pinned.mutable_attribute())->assign(text);
    return {};
  }
  if (name == "output") return set_output(options, name, text);
  if (name == "draco_method") return set_draco_method(options, name, text);
  const auto* const draco = std::ranges::find(kDracoNumbers, name, &DracoNumber::name);
  if (draco == std::ranges::end(kDracoNumbers)) {
    auto set = set_parameter_from_text(options, name, text);
    return set || set.error().cause != Cause::UnknownOption ? set : unknown_name(std::move(set).error());
  }
  const auto value = whole_number(name, text, 0, draco->most);
  if (!value) return value.error();
  (options.mutable_output()->mutable_draco()->*draco->set)(value.value());
  return {};
}

}  // namespace

Result<Timeout> parse_timeout(const Query& query) {
  const auto found = query.find(kTimeoutName);
  if (found == query.end()) return Timeout();
  if (query.count(kTimeoutName) > 1) return given_twice(kTimeoutName);
  const auto value = whole_number(kTimeoutName, found->second, 1, kLongestTimeoutMs);
  if (!value) return value.error();
  return Timeout(std::chrono::milliseconds(value.value()));
}

Result<> check_only_timeout(const Query& query, Cause cause, const std::string& why) {
  const auto other = std::ranges::find_if(query, [](const auto& each) { return each.first != kTimeoutName; });
  if (other == query.end()) return {};
  return Error{cause, "query parameter '" + other->first + "' " + why, other->first};
}

Result<v1::SmoothOptions> parse_query_options(const Query& query) {
  v1::SmoothOptions options;
  if (const auto method = query.find("method"); method != query.end()) {
    options.set_method(method->second);  // first: it decides which other names there are
  }
  if (const auto known = find_method(options.method()); !known) return known.error();
  for (const auto& [name, text] : query) {
    if (query.count(name) > 1) return given_twice(name);
    if (name == "method" || name == kTimeoutName) continue;
    if (auto set = set_one(options, name, text); !set) return std::move(set).error();
  }
  return options;
}

}  // namespace burnish
