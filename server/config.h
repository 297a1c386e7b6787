// Settings of burnishd: flags, each also an environment variable (--grpc-listen is BURNISH_GRPC_LISTEN).
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>

#include "core/run/error.h"

namespace burnish {

/// Where to listen. Port 0 means any free one.
struct Address {
  std::string host;  ///< a name or a number; IPv6 without brackets
  int port = 0;

  std::string text() const;  ///< "127.0.0.1:8080", "[::1]:8080"
  friend bool operator==(const Address&, const Address&) = default;
};

/// Understands "HOST:PORT" and "[IPV6]:PORT". Errors: BadOption.
Result<Address> parse_address(std::string_view text);

struct Config {
  Address grpc_listen{"127.0.0.1", 50051};
  Address http_listen{"127.0.0.1", 8080};
  std::string ports_file;    ///< gets {"grpc": "HOST:PORT", "http": "HOST:PORT"} once both serve; empty: none
  unsigned workers = 0;      ///< jobs that run at once; 0 = one per core
  std::uint32_t queue = 64;  ///< jobs that may wait
  unsigned threads = 0;      ///< cores for a job that is alone; 0 = all
  std::uint64_t max_bytes = std::uint64_t{64} << 20;  ///< of a mesh and of a reference, each
  std::chrono::seconds longest_run{600};              ///< of one job
  std::chrono::seconds grace{30};                     ///< for accepted jobs after a signal to stop
  std::string log_level = "info";
};

/// The settings, or the exit code when there is nothing to serve: 0 after --help and --version, 2 after an
/// error; the text is then printed already.
std::variant<Config, int> parse_config(int argc, const char* const* argv);

}  // namespace burnish
