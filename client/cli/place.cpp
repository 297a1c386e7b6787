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

/// From a file or the environment, never an argument: other users see those.
Result<std::string> token_of(const Place& place) {
  if (place.token_file.empty()) {
    const char* const token = std::getenv("BURNISH_TOKEN");
    return std::string(token ? token : "");
  }
  auto token = read_file(place.token_file);
  if (!token) return token;
  const std::size_t end = token->find_last_not_of(" \t\r\n");
  token->resize(end == std::string::npos ? 0 : end + 1);
  if (token->empty() || token->find_first_of(" \t\r\n") != std::string::npos) {
    return Error{Cause::BadOption,
                 "the token file '" + place.token_file + "' must hold one token and nothing else"};
  }
  return token;
}

}  // namespace

CLI::Option* add_place(CLI::App* command, Place& place) {
  CLI::Option* server = command->add_option("--server", place.server,
                                            "Let the burnishd at HOST:PORT or unix:PATH (gRPC) do it");
  server->type_name("ADDRESS");
  command->add_option("--retries", place.retries, "How often to try again while the server is busy or away")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str()
      ->needs(server);
  add_token_file(command, place);
  add_tls(command, place);
  command->add_flag("--local")->description("Do it in this process (default)")->excludes(server);
  command->add_option("--threads", place.threads, "Threads of the local mode; 0 = all cores")
      ->capture_default_str()
      ->excludes(server);
  command->add_option("--timeout", place.timeout_seconds, "Give up after this many seconds")
      ->check(CLI::Range(0.001, 1e6));
  return server;
}

void add_token_file(CLI::App* command, Place& place) {
  command
      ->add_option("--token-file", place.token_file,
                   "File with the server's token; default: the token in BURNISH_TOKEN")
      ->type_name("FILE");
}

void add_tls(CLI::App* command, Place& place) {
  command
      ->add_option("--tls-ca", place.tls_ca, "Encrypt; PEM file of the authority of the server's certificate")
      ->type_name("FILE");
  CLI::Option* certificate = command
                                 ->add_option("--tls-certificate", place.tls_certificate,
                                              "PEM file: your own certificate, where the server asks for one")
                                 ->type_name("FILE");
  command->add_option("--tls-key", place.tls_key, "PEM file: its key")->type_name("FILE")->needs(certificate);
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

Result<client::CallOptions> call_options(const Place& place, const Console& console) {
  const auto token = token_of(place);
  if (!token) return token.error();
  const char* const trace = std::getenv("TRACEPARENT");  // as OpenTelemetry hands it from program to program
  client::CallOptions options;
  options.timeout = timeout_of(place);
  options.stop = console.stop;
  options.traceparent = trace ? trace : "";
  options.retry.attempts = place.retries + 1;
  options.token = *token;
  return options;
}

Error error_from(const client::Error& error, const Place& place) {
  std::string where = " (server " + place.server;
  if (error.attempts > 1) where += ", " + std::to_string(error.attempts) + " attempts";
  return {cause_from_code(error.cause), error.message + where + ")", error.field, error.retry_after};
}

}  // namespace burnish::cli
