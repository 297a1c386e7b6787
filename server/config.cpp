#include "server/config.h"

#include <sys/un.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <cstdio>
#include <span>

#include "server/config_file.h"
#include "server/config_settings.h"
#include "server/observe/log.h"
#include "server/service/smooth_service.h"
#include "server/status_map.h"

namespace burnish {
namespace {

constexpr std::string_view kUnix = "unix:";

Error bad_address(std::string_view text) {
  return {Cause::BadOption, "'" + printable(text, 200) +
                                "' is not HOST:PORT, such as 127.0.0.1:8080 or [::1]:8080, nor unix:PATH"};
}

Result<Address> parse_socket(std::string_view text) {
  const std::string_view path = text.substr(kUnix.size());
  if (path.empty() || path.find('\0') != std::string_view::npos) return bad_address(text);
  constexpr std::size_t longest = sizeof(sockaddr_un::sun_path) - 1;
  if (path.size() > longest) {
    return Error{Cause::BadOption, "the path of a Unix domain socket has at most " + std::to_string(longest) +
                                       " bytes, '" + printable(path, 200) + "' has " +
                                       std::to_string(path.size())};
  }
  return Address{.host = {}, .port = 0, .path = std::string(path)};
}

CLI::Option* add_flag(CLI::App& app, const Setting& setting) {
  const std::string flag = setting.flag();
  auto* option = setting.shape == SettingShape::Switch
                     ? app.add_flag(flag, setting.meaning)
                     : app.add_option(
                           flag, [](const CLI::results_t&) { return true; }, setting.meaning);
  const std::string value = setting.value_text();
  option->envname(setting.environment())
      ->option_text(setting.range + (value.empty() ? "" : " [" + value + "]") + " (" + setting.environment() +
                    ")");
  if (setting.shape == SettingShape::List)
    option->expected(1, CLI::detail::expected_max_vector_size)->delimiter(',')->allow_extra_args(false);
  return option;
}

/// Flags and environment; CLI11 lets the flag win.
Result<> apply_options(std::span<const Setting> settings, std::span<const CLI::Option* const> options) {
  for (std::size_t i = 0; i < settings.size(); ++i) {
    if (options[i]->empty()) continue;
    if (auto applied = settings[i].set(options[i]->results()); !applied) {
      return Error{Cause::BadOption, settings[i].flag() + " (or " + settings[i].environment() +
                                         "): " + applied.error().message};
    }
  }
  return {};
}

int exit_code(const Error& error) {
  std::fprintf(stderr, "burnishd: %s\n", error.message.c_str());
  return status_of(error.cause).exit_code;
}

}  // namespace

bool Address::is_local() const {
  return is_unix() || host == "localhost" || host == "::1" || host.starts_with("127.");
}

std::string Address::text() const {
  if (is_unix()) return std::string(kUnix) + path;
  const bool v6 = host.find(':') != std::string::npos;
  return (v6 ? "[" + host + "]" : host) + ":" + std::to_string(port);
}

Result<Address> parse_address(std::string_view text) {
  if (text.starts_with(kUnix)) return parse_socket(text);
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) return bad_address(text);
  std::string_view host = text.substr(0, colon);
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  } else if (host.empty() || host.find_first_of("[]:") != std::string_view::npos) {
    return bad_address(text);
  }
  const std::string_view digits = text.substr(colon + 1);
  std::uint16_t port = 0;
  const auto [end, failure] = std::from_chars(digits.begin(), digits.end(), port);
  if (failure != std::errc() || end != digits.end()) return bad_address(text);
  return Address{std::string(host), port};
}

std::string default_store_folder() {
  const auto variable = [](const char* name) {
    const char* const value = std::getenv(name);
    return std::string(value ? value : "");
  };
  if (std::string state = variable("STATE_DIRECTORY"); !state.empty()) return state;
  if (const std::string state = variable("XDG_STATE_HOME"); !state.empty()) return state + "/burnish";
  const std::string home = variable("HOME");
  return (home.empty() ? "/var/lib" : home + "/.local/state") + "/burnish";
}

std::variant<Config, int> parse_config(int argc, const char* const* argv) {
  Config config;
  const std::vector<Setting> settings = settings_of(config);
  CLI::App app("Smooths scanned triangle meshes over gRPC and HTTP.", "burnishd");
  app.set_version_flag("--version", "burnishd " + std::string(version()));
  std::vector<const CLI::Option*> options;
  options.reserve(settings.size());
  for (const Setting& setting : settings) options.push_back(add_flag(app, setting));
  std::string file;
  app.add_option("--config", file, "JSON object of settings; flags and environment win")
      ->envname("BURNISH_CONFIG")
      ->option_text("FILE (BURNISH_CONFIG)");
  app.add_flag("--healthcheck", config.health_check,
               "ask the server that runs with these settings whether it is ready, and end: 0 when it is");
  bool print = false;
  app.add_flag("--print-config", print, "print the settings as --config takes them, and end");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : status_of(Cause::BadOption).exit_code;
  }
  if (!file.empty()) {
    if (auto applied = apply_config_file(file, settings); !applied) return exit_code(applied.error());
  }
  if (auto applied = apply_options(settings, options); !applied) return exit_code(applied.error());
  if (!print) {
    if (config.store_folder.empty()) config.store_folder = default_store_folder();
    return config;
  }
  std::printf("%s\n", config_json(settings).c_str());
  return 0;
}

}  // namespace burnish
