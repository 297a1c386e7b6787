// The settings one by one: how each is spelt, what it may be, and where it goes in a Config. Flags,
// environment, file, --help and --print-config all come from this list.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "server/config.h"

namespace burnish {

/// What a setting's value is in the file: Size is a number or a string such as "64MiB", List an array of
/// strings.
enum class SettingShape : std::uint8_t { Text, Number, Size, Switch, List };

struct Setting {
  std::string name;  ///< as in the file; the flag has two dashes before it
  SettingShape shape;
  std::string range;    ///< what it may be: "0 to 1024"
  std::string meaning;  ///< one line
  /// Takes the values as text; one, or any number for a list. The error's message tells what would be right.
  std::function<Result<>(std::span<const std::string> values)> set;
  std::function<nlohmann::ordered_json()> get;

  std::string flag() const { return "--" + name; }
  std::string environment() const;  ///< BURNISH_GRPC_LISTEN for grpc-listen
  std::string value_text() const;   ///< the present value, sizes with a unit; an empty list gives ""
};

/// They write to `config`, which must outlive them.
std::vector<Setting> settings_of(Config& config);

}  // namespace burnish
