// One call back later, without a thread that sleeps.
#pragma once

#include <chrono>
#include <functional>
#include <memory>

#include <grpcpp/alarm.h>

namespace burnish {

/// Not thread-safe; whoever holds it guards it.
class Timer {
 public:
  /// Calls `fire` once, on a thread of gRPC's, after `delay`; what was set before is forgotten, or is just
  /// being called.
  void set(std::chrono::milliseconds delay, std::function<void()> fire);
  void stop() { alarm_.reset(); }

 private:
  std::unique_ptr<grpc::Alarm> alarm_;
};

}  // namespace burnish
