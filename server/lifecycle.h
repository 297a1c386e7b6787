// Where the server is in its life.
#pragma once

#include <atomic>
#include <cstdint>
#include <string_view>

namespace burnish {

/// Starting: ports are being opened. Serving: work is accepted. Draining: accepted work finishes, new work is
/// refused. Stopped: nothing is left.
enum class LifecycleState : std::uint8_t { Starting, Serving, Draining, Stopped };

std::string_view lifecycle_name(LifecycleState state);

/// Moves forward only: Starting to Serving, Draining or Stopped; Serving to Draining; Draining to Stopped.
/// Thread-safe.
class Lifecycle {
 public:
  LifecycleState state() const { return state_.load(); }
  bool serving() const { return state() == LifecycleState::Serving; }

  /// False, and nothing changes, when the move is not legal from the present state.
  bool move_to(LifecycleState next);

 private:
  std::atomic<LifecycleState> state_ = LifecycleState::Starting;
};

}  // namespace burnish
