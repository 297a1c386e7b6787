// When a call is sent again, and the wait until then.
#pragma once

#include <optional>

#include "client/call_options.h"
#include "client/result.h"

namespace burnish::client {

/// The attempts of one call. Not thread-safe; `options` must outlive it.
class Attempts {
 public:
  using Clock = std::chrono::steady_clock;

  explicit Attempts(const CallOptions& options);

  /// Until when every attempt must end; unset: never.
  const std::optional<Clock::time_point>& deadline() const { return deadline_; }

  /// After an attempt failed: true when its time has come to be sent again. False when `error` is the call's;
  /// its attempts are then counted, and a stop during the wait has made it "cancelled".
  bool again(Error& error);

 private:
  std::chrono::milliseconds delay(const Error& error);

  const CallOptions& options_;
  const std::optional<Clock::time_point> deadline_;
  int made_ = 0;
};

/// Whether what failed passes by itself.
bool passes(const Error& error);

}  // namespace burnish::client
