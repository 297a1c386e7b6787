#include "server/config_file.h"

#include <algorithm>
#include <fstream>
#include <optional>
#include <utility>
#include <vector>

#include "server/http/strict_json.h"
#include "server/observe/log.h"

namespace burnish {
namespace {

using Json = nlohmann::json;

constexpr const char* kRoot = "settings";
constexpr std::size_t kMostBytes = std::size_t{1} << 20;  ///< a device file would never end

Error wrong(std::string message) { return {Cause::BadOption, std::move(message)}; }

Result<std::string> read(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text(kMostBytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!file.is_open() || file.bad()) return wrong("cannot be read");
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.size() > kMostBytes) return wrong("is longer than 1 MiB");
  return text;
}

std::string type_for(SettingShape shape) {
  switch (shape) {
    case SettingShape::Text:
      return "a string";
    case SettingShape::Number:
      return "a number";
    case SettingShape::Size:
      return "a number or a string such as \"64MiB\"";
    case SettingShape::Switch:
      return "true or false";
    case SettingShape::List:
      return "an array of strings";
  }
  return {};
}

/// The value as a flag would have it; nothing when its type is wrong.
std::optional<std::vector<std::string>> as_texts(SettingShape shape, const Json& value) {
  const auto is_text = [](const Json& json) { return json.is_string(); };
  if (shape == SettingShape::List) {
    if (!value.is_array() || !std::ranges::all_of(value, is_text)) return {};
    return value.get<std::vector<std::string>>();
  }
  const bool number = shape == SettingShape::Number || shape == SettingShape::Size;
  const bool text = shape == SettingShape::Text || shape == SettingShape::Size;
  if (text && value.is_string()) return {{value.get<std::string>()}};
  if ((number && value.is_number()) || (shape == SettingShape::Switch && value.is_boolean())) {
    return {{value.dump()}};
  }
  return {};
}

Result<> apply(const std::string& key, const Json& value, std::span<const Setting> settings) {
  const std::string place = kRoot + ("." + key);
  const auto setting = std::ranges::find(settings, key, &Setting::name);
  if (setting == settings.end()) return wrong(place + " is no setting");
  const auto texts = as_texts(setting->shape, value);
  if (!texts) return wrong(place + " must be " + type_for(setting->shape) + ", not " + value.type_name());
  if (auto applied = setting->set(*texts); !applied) return wrong(place + ": " + applied.error().message);
  return {};
}

Result<> apply(const std::string& path, std::span<const Setting> settings) {
  const auto text = read(path);
  if (!text) return text.error();
  const auto json = parse_strict_json(*text, kRoot);
  if (!json) return json.error();
  if (!json->is_object()) return wrong("is no JSON object");
  for (const auto& [key, value] : json->items()) {
    if (auto applied = apply(key, value, settings); !applied) return applied;
  }
  return {};
}

}  // namespace

Result<> apply_config_file(const std::string& path, std::span<const Setting> settings) {
  const auto applied = apply(path, settings);
  if (!applied) return wrong(printable(path + ": " + applied.error().message));
  return {};
}

std::string config_json(std::span<const Setting> settings) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const Setting& setting : settings) json[setting.name] = setting.get();
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace burnish
