// Where a command's work is done, in this process or by a server, and how long it may take.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "client/call_options.h"
#include "client/cli/console.h"
#include "client/result.h"
#include "client/smoothing_client.h"
#include "core/run/error.h"
#include "core/run/run_control.h"

namespace burnish::cli {

struct Place {
  std::string server;  ///< HOST:PORT or unix:PATH; empty: in this process
  unsigned threads = 0;
  std::string tls_ca, tls_certificate, tls_key;  ///< files; all empty: the connection is not encrypted
  std::string token_file;
  int retries = 3;
  std::optional<double> timeout_seconds;
};

/// Gives the option of the server, which others may rule out.
CLI::Option* add_place(CLI::App* command, Place& place);

/// For work in this process; the deadline counts from now.
RunControl run_control(const Place& place, const Console& console);

/// For work by the server, with the token of place.token_file, else of BURNISH_TOKEN. Errors: FileError,
/// BadOption.
Result<client::CallOptions> call_options(const Place& place, const Console& console);

/// To place.server. Errors: FileError.
Result<client::SmoothingClient> connect(const Place& place);
void add_tls(CLI::App* command, Place& place);
void add_token_file(CLI::App* command, Place& place);

/// The server's error as the command line's own.
Error error_from(const client::Error& error, const Place& place);

}  // namespace burnish::cli
