#include "client/cli/place.h"

#include <chrono>
#include <cstdlib>

#include "client/cli/files.h"
#include "server/status_map.h"

namespace burnish::cli {
namespace {

std::optional<std::chrono::milliseconds> timeout_of(const Place& place) {
  if (!place.timeout_seconds) return std::nullopt;
  return std::chrono::ceil<std::chrono::milliseconds>(std::chrono::duration<double>(*place.timeout_seconds));
}

}  // namespace

void add_place(CLI::App* command, Place& place) {
  CLI::Option* server = command->add_option(
      "--server", place.server,
      "Let the burnishd at HOST:PORT or unix:PATH (gRPC) do it; its token is taken from BURNISH_TOKEN");
  command->add_option("--retries", place.retries, "How often to try again while the server is busy or away")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str()
      ->needs(server);
  add_tls(command, place);
  command->add_flag("--local")->description("Do it in this process (default)")->excludes(server);
  command->add_option("--threads", place.threads, "Threads of the local mode; 0 = all cores")
      ->capture_default_str()
      ->excludes(server);
  command->add_option("--timeout", place.timeout_seconds, "Give up after this many seconds")
      ->check(CLI::Range(0.001, 1e6));
}

void add_tls(CLI::App* command, Place& place) {
  command->add_option("--tls-ca", place.tls_ca,
                      "Encrypt; PEM file of the authority of the server's certificate");
  CLI::Option* certificate =
      command->add_option("--tls-certificate", place.tls_certificate,
                          "PEM file: your own certificate, where the server asks for one");
  command->add_option("--tls-key", place.tls_key, "PEM file: its key")->needs(certificate);
}

Result<client::SmoothingClient> connect(const Place& place) {
  client::TlsOptions tls;
  bool encrypted = false;
  for (const auto& [path, text] :
       {std::pair(&place.tls_ca, &tls.authority), std::pair(&place.tls_certificate, &tls.certificate),
        std::pair(&place.tls_key, &tls.key)}) {
    if (path->empty()) continue;
    encrypted = true;
    auto read = read_file(*path);
    if (!read) return std::move(read).error();
    *text = std::move(read).value();
  }
  if (!encrypted) return client::SmoothingClient(place.server);
  return client::SmoothingClient(place.server, tls);
}

RunControl run_control(const Place& place, const Console& console) {
  RunControl run{.stop = console.stop, .threads = place.threads};
  if (const auto timeout = timeout_of(place)) run.deadline = RunControl::Clock::now() + *timeout;
  return run;
}

client::CallOptions call_options(const Place& place, const Console& console) {
  const char* const token = std::getenv("BURNISH_TOKEN");  // never an argument: other users see those
  const char* const trace = std::getenv("TRACEPARENT");  // as OpenTelemetry hands it from program to program
  return {.timeout = timeout_of(place),
          .stop = console.stop,
          .traceparent = trace ? trace : "",
          .retry = {.attempts = place.retries + 1},
          .token = token ? token : ""};
}

Error error_from(const client::Error& error, const Place& place) {
  std::string where = " (server " + place.server;
  if (error.attempts > 1) where += ", " + std::to_string(error.attempts) + " attempts";
  return {cause_from_code(error.cause), error.message + where + ")", error.field, error.retry_after};
}

}  // namespace burnish::cli
