#include "client/cli/preferences.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "client/cli/files.h"
#include "server/http/strict_json.h"

namespace burnish::cli {
namespace {

enum class Shape : std::uint8_t { Text, Number };

struct Key {
  const char* name;  ///< in the file; the flag without its hyphens
  Shape shape;
  bool has_variable = true;  ///< burnishd has variables of the other names
};
/// Those that rule others out come first.
constexpr std::array<Key, 9> kKeys = {{{"server", Shape::Text},
                                       {"method", Shape::Text},
                                       {"retries", Shape::Number},
                                       {"timeout", Shape::Number},
                                       {"threads", Shape::Number, false},
                                       {"token-file", Shape::Text},
                                       {"tls-ca", Shape::Text, false},
                                       {"tls-certificate", Shape::Text, false},
                                       {"tls-key", Shape::Text, false}}};

Error wrong(std::string message) { return {Cause::BadOption, std::move(message)}; }

std::string variable(const char* prefix, std::string_view name) {
  std::string result = prefix;
  for (const char c : name)
    result += c == '-' ? '_' : static_cast<char>(c >= 'a' && c <= 'z' ? c - 'a' + 'A' : c);
  return result;
}

std::string from_environment(const std::string& name) {
  const char* const value = std::getenv(name.c_str());
  return value ? value : "";
}

/// Whether the flags of the call, and what was applied before, leave room for the option.
bool is_open(const CLI::Option& option) {
  if (option.count() > 0) return false;
  const auto given = [](const CLI::Option* other) { return other->count() > 0; };
  return std::ranges::none_of(option.get_excludes(), given) && std::ranges::all_of(option.get_needs(), given);
}

Result<> set(CLI::Option& option, const std::string& value, const std::string& place) try {
  option.add_result(value);
  option.run_callback();
  return {};
} catch (const CLI::Error& refused) {
  return wrong(place + ": " + refused.what());
}

using Values = std::vector<std::pair<std::string, std::string>>;

Result<Values> read_preferences(const std::string& path) {
  constexpr std::uintmax_t kMostBytes = std::uintmax_t{1} << 20;
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return wrong(path + ": is no file");
  if (std::filesystem::file_size(path, ignored) > kMostBytes) return wrong(path + ": is longer than 1 MiB");
  const auto text = read_file(path);
  if (!text) return wrong(text.error().message);
  const auto json = parse_strict_json(*text, "settings");
  if (!json) return wrong(path + ": " + json.error().message);
  if (!json->is_object()) return wrong(path + ": is no JSON object");
  Values values;
  for (const auto& [name, value] : json->items()) {
    const auto key = std::ranges::find(kKeys, name, &Key::name);
    if (key == kKeys.end()) return wrong(path + ": settings." + name + " is no setting");
    const bool text_wanted = key->shape == Shape::Text;
    if (text_wanted ? !value.is_string() : !value.is_number()) {
      return wrong(path + ": settings." + name + " must be a " + (text_wanted ? "string" : "number") +
                   ", not " + value.type_name());
    }
    values.emplace_back(name, text_wanted ? value.get<std::string>() : value.dump());
  }
  return values;
}

/// The file that counts; empty when there is none.
std::string file_of(const std::string& given) {
  if (!given.empty()) return given;
  if (const std::string named = from_environment("BURNISH_CONFIG"); !named.empty()) return named;
  const std::string usual = default_preferences_file();
  std::error_code ignored;
  return std::filesystem::exists(usual, ignored) ? usual : "";
}

}  // namespace

std::string default_preferences_file() {
  const std::string folder = from_environment("XDG_CONFIG_HOME"), home = from_environment("HOME");
  if (!folder.empty()) return folder + "/burnish/config.json";
  return home.empty() ? "" : home + "/.config/burnish/config.json";
}

std::vector<std::string> preference_keys() {
  std::vector<std::string> names;
  for (const Key& key : kKeys) names.emplace_back(key.name);
  return names;
}

std::string preference_variable(const std::string& key) {
  const auto found = std::ranges::find(kKeys, key, &Key::name);
  return found != kKeys.end() && found->has_variable ? variable("BURNISH_", key) : "";
}

Result<> apply_preferences(CLI::App& command, const std::string& file) {
  Values values;
  const std::string path = file_of(file);
  if (!path.empty()) {
    auto read = read_preferences(path);
    if (!read) return read.error();
    values = std::move(*read);
  }
  for (const Key& key : kKeys) {
    CLI::Option* const option = command.get_option_no_throw(std::string("--") + key.name);
    if (option == nullptr || !is_open(*option)) continue;
    const std::string name = preference_variable(key.name),
                      from_variable = name.empty() ? "" : from_environment(name);
    if (!from_variable.empty()) {
      if (auto done = set(*option, from_variable, name); !done) return done;
      continue;
    }
    const auto value = std::ranges::find(values, key.name, &Values::value_type::first);
    if (value == values.end()) continue;
    // A token of the environment goes before one that the file names.
    if (std::string_view(key.name) == "token-file" && !from_environment("BURNISH_TOKEN").empty()) continue;
    if (auto done = set(*option, value->second, path + ": settings." + key.name); !done) return done;
  }
  return {};
}

}  // namespace burnish::cli
