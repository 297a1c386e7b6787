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

/// A number or a size within bounds.
Setting bounded(std::string name, SettingShape shape, std::uint64_t least, std::uint64_t most,
                std::string meaning, const std::function<void(std::uint64_t)>& store,
                std::function<std::uint64_t()> load) {
  const bool size = shape == SettingShape::Size;
  const auto text = [size](std::uint64_t n) { return size ? size_text(n) : std::to_string(n); };
  std::string range = text(least) + " to " + text(most);
  auto set = [=, wanted = (size ? "a size such as 64MiB, from " : "a whole number from ") +
                          range](std::span<const std::string> values) -> Result<> {
    const auto parsed = size ? parse_size(values.front()) : parse_number(values.front());
    if (!parsed || *parsed < least || *parsed > most) return not_a(values.front(), wanted);
    store(*parsed);
    return {};
  };
  return {std::move(name),    shape,          std::move(range),
          std::move(meaning), std::move(set), [load = std::move(load)] { return Json(load()); }};
}

template <class T>
Setting integer(std::string name, SettingShape shape, T& value, std::uint64_t least, std::uint64_t most,
                std::string meaning) {
  return bounded(
      std::move(name), shape, least, most, std::move(meaning),
      [&value](std::uint64_t n) { value = static_cast<T>(n); },
      [&value] { return static_cast<std::uint64_t>(value); });
}

template <class T>
Setting number(std::string name, T& value, std::uint64_t least, std::uint64_t most, std::string meaning) {
  return integer(std::move(name), SettingShape::Number, value, least, most, std::move(meaning));
}

template <class T>
Setting size(std::string name, T& value, std::uint64_t least, std::uint64_t most, std::string meaning) {
  return integer(std::move(name), SettingShape::Size, value, least, most, std::move(meaning));
}

Setting seconds(std::string name, std::chrono::seconds& value, std::uint64_t least, std::uint64_t most,
                std::string meaning) {
  return bounded(
      std::move(name), SettingShape::Number, least, most, std::move(meaning),
      [&value](std::uint64_t n) { value = std::chrono::seconds(n); },
      [&value] { return static_cast<std::uint64_t>(value.count()); });
}

Setting path(std::string name, std::string& value, std::string range, std::string meaning) {
  const auto set = [&value](std::span<const std::string> values) -> Result<> {
    if (values.front().find('\0') != std::string::npos) return not_a(values.front(), "a path");
    value = values.front();
    return {};
  };
  return {std::move(name), SettingShape::Text, std::move(range), std::move(meaning), set, [&value] {
            return Json(value);
          }};
}

Setting address(std::string name, Address& value, std::string meaning) {
  const auto set = [&value](std::span<const std::string> values) -> Result<> {
    auto parsed = parse_address(values.front());
    if (!parsed) return std::move(parsed).error();
    value = std::move(parsed).value();
    return {};
  };
  return {std::move(name), SettingShape::Text, "HOST:PORT or unix:PATH", std::move(meaning), set, [&value] {
            return Json(value.text());
          }};
}

Setting choice(std::string name, std::string& value, std::span<const char* const> choices,
               std::string meaning) {
  std::string range;
  for (const char* const one : choices) range += (range.empty() ? "" : ", ") + std::string(one);
  const auto set = [&value, choices, range](std::span<const std::string> values) -> Result<> {
    if (std::ranges::find(choices, values.front()) == choices.end()) {
      return not_a(values.front(), "one of " + range);
    }
    value = values.front();
    return {};
  };
  return {
      std::move(name), SettingShape::Text, range, std::move(meaning), set, [&value] { return Json(value); }};
}

Setting on_or_off(std::string name, bool& value, std::string meaning) {
  const auto set = [&value](std::span<const std::string> values) -> Result<> {
    if (values.front() != "true" && values.front() != "false") return not_a(values.front(), "true or false");
    value = values.front() == "true";
    return {};
  };
  return {std::move(name), SettingShape::Switch, "true, false", std::move(meaning), set, [&value] {
            return Json(value);
          }};
}

/// What a host may be named, so that it can stand in paths and metadata.
Setting replica_name(std::string name, std::string& value, std::string meaning) {
  const auto set = [&value](std::span<const std::string> values) -> Result<> {
    const std::string& text = values.front();
    const bool fine = text.size() <= 63 && !text.starts_with('-') && std::ranges::all_of(text, [](char c) {
                        return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
                      });
    if (!fine) return not_a(text, "a name of up to 63 small letters, digits and hyphens");
    value = text;
    return {};
  };
  return {
      std::move(name), SettingShape::Text, "NAME", std::move(meaning), set, [&value] { return Json(value); }};
}

/// As browsers send it; anything else would never match and only look allowed.
bool is_origin(std::string_view text) {
  if (text == "*") return true;
  const std::size_t scheme = text.find("://");
  if (scheme == 0 || scheme == std::string_view::npos || scheme + 3 == text.size()) return false;
  return std::ranges::none_of(text, [](unsigned char c) { return c <= ' ' || c > '~' || std::isupper(c); }) &&
         text.find_first_of("/*?#,@", scheme + 3) == std::string_view::npos;
}

Setting origins(std::string name, std::vector<std::string>& value, std::string meaning) {
  const auto set = [&value](std::span<const std::string> values) -> Result<> {
    for (const std::string& one : values) {
      if (!is_origin(one)) return not_a(one, "* or an origin such as https://scans.example");
    }
    value.assign(values.begin(), values.end());
    return {};
  };
  return {
      std::move(name), SettingShape::List, "* or SCHEME://HOST[:PORT]", std::move(meaning), set, [&value] {
        return Json(value);
      }};
}

std::vector<Setting> transport_settings(Config& config) {
  return {
      address("grpc-listen", config.grpc_listen, "where to serve gRPC; port 0: any"),
      address("http-listen", config.http_listen, "where to serve HTTP; port 0: any"),
      path("ports-file", config.ports_file, "FILE", "gets both addresses as JSON once both serve"),
      path("tokens", config.tokens_file, "FILE", "who may call, by bearer token; default: everybody"),
      path("tls-certificate", config.tls.certificate, "FILE",
           "PEM: certificate of both ports; default: no TLS"),
      path("tls-key", config.tls.key, "FILE", "PEM: its key"),
      path("tls-client-ca", config.tls.client_ca, "FILE",
           "PEM: authority of the certificates that callers must show; default: none"),
      on_or_off("insecure", config.insecure, "listen beyond this machine without tokens"),
      size("max-unary-bytes", config.max_unary_bytes, 64 * kKi, kGi,
           "largest message of gRPC; streams carry larger meshes"),
      number("max-streams", config.max_streams, 1, 65536, "gRPC calls at once on one connection"),
      on_or_off("grpc-compression", config.grpc_compression, "gzip answers of gRPC"),
      number("max-connections", config.max_connections, 1, 65536, "HTTP connections at once"),
      seconds("head-seconds", config.head_timeout, 1, 3600, "time for the head of an HTTP request"),
      size("min-body-rate", config.min_body_rate, 0, kGi,
           "bytes a second that an HTTP body must bring after its first 10 s; 0: any"),
      origins("cors-origin", config.cors_origins,
              "web page that may call from a browser, once for each; *: all"),
  };
}

std::vector<Setting> job_settings(Config& config) {
  return {
      number("workers", config.workers, 0, 1024, "jobs that run at once; 0: one per core"),
      on_or_off("sandbox", config.sandbox, "decode and smooth in helper processes without rights"),
      number("queue", config.queue, 0, 65536, "jobs that may wait; more are refused at once"),
      seconds("queue-seconds", config.queue_seconds, 0, 365 * 86400,
              "of one core that the jobs at hand may be expected to take; 0: any"),
      number("threads", config.threads, 0, 1024, "cores for a job that is alone; 0: all"),
      size("max-memory", config.max_memory, 0, 1024 * kTi,
           "estimated memory of all accepted jobs; 0: half of what there is"),
      path("spool-folder", config.spool_folder, "FOLDER",
           "for request bodies over 2 MiB; default: the system's temporary folder"),
      size("max-spool-bytes", config.max_spool_bytes, 1, 1024 * kTi,
           "request bodies in the server, together"),
      path("store", config.store_folder, "FOLDER",
           "for jobs, uploads and results; default: the state folder of the user"),
      replica_name("replica", config.replica, "begins the ids of jobs and uploads, for a balancer"),
      size("max-store-bytes", config.max_store_bytes, 1, 1024 * kTi, "all files in the store, together"),
      number("max-jobs", config.max_jobs, 1, 1'000'000, "kept jobs that have not ended"),
      seconds("jobs-seconds", config.jobs_seconds, 1, 365 * 86400,
              "of one core that kept jobs may be expected to take"),
      seconds("keep-seconds", config.keep, 1, 365 * 86400,
              "for how long ended jobs, results, meshes and uploads are kept"),
      seconds("max-seconds", config.longest_run, 1, 86400, "longest run of one job"),
      seconds("grace-seconds", config.grace, 0, 86400, "time for accepted jobs after a signal to stop"),
  };
}

std::vector<Setting> limit_settings(RequestLimits& limits) {
  return {
      size("max-bytes", limits.mesh.max_bytes, 1, kTi, "largest mesh, and largest reference"),
      number("max-vertices", limits.mesh.max_vertices, 1, 1'000'000'000, "most vertices of a mesh"),
      number("max-triangles", limits.mesh.max_triangles, 1, 1'000'000'000, "most triangles of a mesh"),
      number("max-attributes", limits.mesh.max_attributes, 1, 65536,
             "most attributes of a Draco mesh, elements or properties of a PLY"),
      size("max-line-bytes", limits.mesh.max_line_bytes, 1, kGi, "longest line of a text mesh"),
      number("max-iterations", limits.max_iterations, 0, 100'000, "most iterations of one job"),
      size("max-option-bytes", limits.max_option_bytes, 1, kMi, "largest options of one request"),
  };
}

}  // namespace

std::string Setting::environment() const {
  std::string result = "BURNISH_" + name;
  std::ranges::transform(result, result.begin(),
                         [](unsigned char c) { return c == '-' ? '_' : static_cast<char>(std::toupper(c)); });
  return result;
}

std::string Setting::value_text() const {
  const Json value = get();
  if (shape == SettingShape::Size) return size_text(value.get<std::uint64_t>());
  if (shape == SettingShape::List && value.empty()) return {};
  return value.is_string() ? value.get<std::string>() : value.dump();
}

std::vector<Setting> settings_of(Config& config) {
  std::vector<Setting> all = transport_settings(config);
  std::ranges::move(job_settings(config), std::back_inserter(all));
  std::ranges::move(limit_settings(config.limits), std::back_inserter(all));
  all.push_back(choice("log-level", config.log_level, kLogLevels, "least level to log"));
  return all;
}

}  // namespace burnish
