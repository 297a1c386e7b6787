#include "server/config_settings.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

#include "server/observe/log.h"

namespace burnish {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint64_t kKi = 1024, kMi = kKi << 10, kGi = kMi << 10, kTi = kGi << 10;
constexpr std::pair<std::string_view, std::uint64_t> kUnits[] = {
    {"TiB", kTi}, {"GiB", kGi}, {"MiB", kMi}, {"KiB", kKi}};

std::string size_text(std::uint64_t bytes) {
  for (const auto& [unit, factor] : kUnits) {
    if (bytes > 0 && bytes % factor == 0) return std::to_string(bytes / factor) + std::string(unit);
  }
  return std::to_string(bytes);
}

/// Digits and nothing else.
std::optional<std::uint64_t> parse_number(std::string_view text) {
  std::uint64_t number = 0;
  const auto [end, failure] = std::from_chars(text.begin(), text.end(), number);
  if (failure != std::errc() || end != text.end()) return {};
  return number;
}

/// CLI11's AsSizeValue would read 010 as eight and a lone unit as one of it.
std::optional<std::uint64_t> parse_size(std::string_view text) {
  for (const auto& [unit, factor] : kUnits) {
    if (!text.ends_with(unit)) continue;
    const auto number = parse_number(text.substr(0, text.size() - unit.size()));
    if (!number || *number > std::numeric_limits<std::uint64_t>::max() / factor) return {};
    return *number * factor;
  }
  return parse_number(text);
}

Error not_a(std::string_view value, const std::string& wanted) {
  return {Cause::BadOption, "'" + printable(value, 100) + "' is not " + wanted};
}

template <class T>
Setting number(std::string name, T& value, std::uint64_t least, std::uint64_t most, std::string meaning) {
  const std::string range = std::to_string(least) + " to " + std::to_string(most);
  return {std::move(name), SettingShape::Number, range, std::move(meaning),
          [&value, least, most, range](std::span<const std::string> values) -> Result<> {
            const auto parsed = parse_number(values.front());
            if (!parsed || *parsed < least || *parsed > most) {
              return not_a(values.front(), "a whole number from " + range);
            }
            value = static_cast<T>(*parsed);
            return {};
          },
          [&value] { return Json(value); }};
}

Setting seconds(std::string name, std::chrono::seconds& value, std::uint64_t least, std::uint64_t most,
                std::string meaning) {
  const std::string range = std::to_string(least) + " to " + std::to_string(most);
  return {std::move(name), SettingShape::Number, range, std::move(meaning),
          [&value, least, most, range](std::span<const std::string> values) -> Result<> {
            const auto parsed = parse_number(values.front());
            if (!parsed || *parsed < least || *parsed > most) {
              return not_a(values.front(), "a whole number of seconds from " + range);
            }
            value = std::chrono::seconds(*parsed);
            return {};
          },
          [&value] { return Json(value.count()); }};
}
