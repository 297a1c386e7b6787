#include "server/config.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <charconv>
#include <iterator>

#include "server/observe/log.h"
#include "server/service/smooth_service.h"
#include "server/status_map.h"

namespace burnish {
namespace {

Error bad_address(std::string_view text) {
  return {Cause::BadOption,
          "'" + std::string(text) + "' is not HOST:PORT, such as 127.0.0.1:8080 or [::1]:8080"};
}

/// BURNISH_GRPC_LISTEN for --grpc-listen.
std::string environment_name(std::string flag) {
  flag.erase(0, 2);
  std::ranges::transform(flag, flag.begin(),
                         [](unsigned char c) { return c == '-' ? '_' : static_cast<char>(std::toupper(c)); });
  return "BURNISH_" + flag;
}

template <class T>
CLI::Option* add(CLI::App& app, const std::string& flag, T& value, const std::string& text) {
  return app.add_option(flag, value, text)->envname(environment_name(flag))->capture_default_str();
}

void add_address(CLI::App& app, const std::string& flag, Address& value, const std::string& text) {
  const auto read = [&value](const std::string& given) {
    auto address = parse_address(given);
    if (!address) throw CLI::ValidationError(address.error().message);
    value = *address;
  };
  app.add_option_function<std::string>(flag, read, text)
      ->envname(environment_name(flag))
      ->type_name("HOST:PORT")
      ->default_str(value.text());
}

void add_seconds(CLI::App& app, const std::string& flag, std::chrono::seconds& value, int least,
                 const std::string& text) {
  const auto read = [&value](const int& given) { value = std::chrono::seconds(given); };
  app.add_option_function<int>(flag, read, text)
      ->envname(environment_name(flag))
      ->check(CLI::Range(least, 86400))
      ->default_str(std::to_string(value.count()));
}

}  // namespace

std::string Address::text() const {
  const bool v6 = host.find(':') != std::string::npos;
  return (v6 ? "[" + host + "]" : host) + ":" + std::to_string(port);
}

Result<Address> parse_address(std::string_view text) {
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

std::variant<Config, int> parse_config(int argc, const char* const* argv) {
  Config config;
  CLI::App app("Smooths scanned triangle meshes over gRPC and HTTP.", "burnishd");
  app.set_version_flag("--version", "burnishd " + std::string(version()));
  add_address(app, "--grpc-listen", config.grpc_listen, "where to serve gRPC; port 0: any");
  add_address(app, "--http-listen", config.http_listen, "where to serve HTTP; port 0: any");
  add(app, "--ports-file", config.ports_file, "gets the addresses as JSON once both serve")
      ->type_name("FILE");
  add(app, "--workers", config.workers, "jobs that run at once; 0: one per core")->check(CLI::Range(0, 1024));
  add(app, "--queue", config.queue, "jobs that may wait; more are refused at once")
      ->check(CLI::Range(0, 1024));
  add(app, "--threads", config.threads, "cores for a job that is alone; 0: all")->check(CLI::Range(0, 1024));
  add(app, "--max-bytes", config.max_bytes, "largest mesh, and largest reference, in bytes")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1} << 40));
  add_seconds(app, "--max-seconds", config.longest_run, 1, "longest run of one job");
  add_seconds(app, "--grace-seconds", config.grace, 0, "time for accepted jobs after a signal to stop");
  add(app, "--log-level", config.log_level, "least level to log")
      ->check(CLI::IsMember(std::vector<std::string>(std::begin(kLogLevels), std::end(kLogLevels))));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : status_of(Cause::BadOption).exit_code;
  }
  return config;
}

}  // namespace burnish
