// How a call is made: its time, its size, what it tells on the way, and when it is tried again.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include "burnish/v1/smoothing.pb.h"

namespace burnish::client {

/// When a call that failed is sent again. Every call is pure, so all of them may be; only what passes by
/// itself is: a server that cannot be reached, starts or drains, "queue_full" and "memory_full". The delay
/// before attempt n+1 is random in [0, min(longest_delay, initial_delay * multiplier^(n-1))), after the time
/// that the server asked for, if it did. What could not start before the timeout is not waited for.
struct RetryPolicy {
  int attempts = 4;  ///< in all; 1 or less: no second one
  std::chrono::milliseconds initial_delay{100};
  double multiplier = 2;
  std::chrono::milliseconds longest_delay{5000};
  /// Random in [0, 1); unset: a generator of the thread's own.
  std::function<double()> jitter = {};
  /// Waits and returns true, or false as soon as the token is stopped; unset: on the steady clock.
  std::function<bool(std::chrono::milliseconds, const std::stop_token&)> wait = {};
};

enum class Compression : std::uint8_t { None, Gzip };

/// Every default suits a call that may take as long as it takes. The functions are called on the thread that
/// makes the call.
struct CallOptions {
  std::optional<std::chrono::milliseconds> timeout = {};  ///< of all attempts together; unset: none
  std::stop_token stop = {};                              ///< a stop from any thread ends the call at once
  /// W3C Trace Context of whatever this call is a part of; the server's log names its trace. Empty: none.
  std::string traceparent = {};
  /// Called for each progress message of the server, which needs a stream: given, it makes every smooth()
  /// one. Starts over when the call is tried again. The answer waits while it runs; what it throws ends the
  /// call with "internal".
  std::function<void(const v1::SmoothProgress&)> progress = {};
  RetryPolicy retry = {};
  /// Sent as "authorization: Bearer TOKEN"; empty: none. Anybody on the way reads it unless the channel is
  /// encrypted.
  std::string token = {};
  Compression compression = Compression::None;  ///< of what is sent
  /// Meshes and options of more bytes go by stream. The server takes 8 MiB at most unless told otherwise.
  std::size_t unary_bytes = std::size_t{4} << 20;
};

}  // namespace burnish::client
