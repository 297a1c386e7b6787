// Settings of burnishd. Each is a flag, an environment variable (--grpc-listen is BURNISH_GRPC_LISTEN) and a
// key of the JSON file that --config names ("grpc-listen"). A flag wins over the environment, the environment
// over the file. docs/operations.md lists them all.
#pragma once

#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/run/error.h"
#include "server/http/page.h"
#include "server/security/tls.h"
#include "server/service/limits.h"

namespace burnish {

/// Where to listen: a TCP port, 0 meaning any free one, or a Unix domain socket.
struct Address {
  std::string host;  ///< a name or a number; IPv6 without brackets; "" for a socket
  int port = 0;
  std::string path = {};  ///< of a Unix domain socket; "" for TCP

  bool is_unix() const { return !path.empty(); }
  /// A socket, or a number or name that is this machine's alone.
  bool is_local() const;
  std::string text() const;  ///< "127.0.0.1:8080", "[::1]:8080", "unix:/run/burnish.sock"
  friend bool operator==(const Address&, const Address&) = default;
};

/// Understands "HOST:PORT", "[IPV6]:PORT" and "unix:PATH". Errors: BadOption.
Result<Address> parse_address(std::string_view text);

struct Config {
  Address grpc_listen{"127.0.0.1", 50051};
  Address http_listen{"127.0.0.1", 8080};
  std::string ports_file;  ///< gets {"grpc": "HOST:PORT", "http": "HOST:PORT"} once both serve; empty: none

  std::string tokens_file;  ///< who may call, as tokens.h reads it; empty: everybody
  TlsFiles tls;             ///< of both transports; empty: not encrypted
  bool insecure = false;    ///< listen beyond this machine without tokens

  bool sandbox = true;         ///< decode, smooth and encode in helper processes without rights
  std::string helper_program;  ///< that does it, as sandbox.h says; no setting; empty: no helpers

  unsigned workers = 0;                     ///< jobs that run at once; 0 = one per core
  std::uint32_t queue = 64;                 ///< jobs that may wait
  std::chrono::seconds queue_seconds{600};  ///< of one core that they are expected to take; 0 = any
  unsigned threads = 0;                     ///< cores for a job that is alone; 0 = all
  std::uint64_t max_memory = 0;  ///< estimated bytes of all accepted jobs; 0 = half of the memory there is
  std::string spool_folder;      ///< for request bodies over 2 MiB; empty: the system's temporary folder
  std::uint64_t max_spool_bytes = std::uint64_t{8} << 30;  ///< of all request bodies together

  std::string
      store_folder;     ///< for jobs, uploads and results; empty: a temporary one that goes with the server
  std::string replica;  ///< names of jobs and uploads begin with it; empty: with nothing
  std::uint64_t max_store_bytes = std::uint64_t{64} << 30;  ///< of all files in it
  std::uint32_t max_jobs = 10'000;                          ///< kept jobs that have not ended
  std::chrono::seconds jobs_seconds{7 * 24 * 3600};         ///< of one core that they are expected to take
  std::chrono::seconds keep{24 * 3600};                     ///< for ended jobs, results, meshes and uploads

  RequestLimits limits;                                    ///< --max-bytes, --max-vertices, ...
  std::uint64_t max_unary_bytes = std::uint64_t{8} << 20;  ///< of a gRPC message; streams carry more
  int max_streams = 1024;                                  ///< gRPC calls at once on one connection
  bool grpc_compression = false;  ///< gzip answers of gRPC for callers that accept it

  std::uint32_t max_connections = 1024;   ///< HTTP connections at once; more are told to come back
  std::chrono::seconds head_timeout{10};  ///< for the head of an HTTP request
  std::uint32_t min_body_rate = 1024;     ///< bytes a second that a body must bring after its first 10 s
  std::vector<std::string> cors_origins;  ///< pages that may call from a browser; "*": all; empty: none
  std::span<const PageFile> page = {};    ///< what `/` shows; no setting; empty: nothing

  std::chrono::seconds longest_run{600};  ///< of one job
  std::chrono::seconds grace{30};         ///< for accepted jobs after a signal to stop
  std::string log_level = "info";
  bool health_check = false;  ///< ask the server that runs with these settings, and end; no setting
};

/// Where jobs are kept unless a setting tells: $STATE_DIRECTORY, as systemd sets it, $XDG_STATE_HOME/burnish,
/// or
/// ~/.local/state/burnish.
std::string default_store_folder();

/// The settings, or the exit code when there is nothing to serve: 0 after --help and --version, 2 after an
/// error; the text is then printed already.
std::variant<Config, int> parse_config(int argc, const char* const* argv);

}  // namespace burnish
