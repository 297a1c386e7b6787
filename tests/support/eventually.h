// Bounded polling of a state that another thread changes.
#pragma once

#include <chrono>
#include <functional>
#include <thread>

namespace burnish::testing {

/// True as soon as `holds` does; false when it does not within `limit`.
inline bool eventually(const std::function<bool()>& holds,
                       std::chrono::milliseconds limit = std::chrono::seconds(20)) {
  const auto end = std::chrono::steady_clock::now() + limit;
  while (!holds()) {
    if (std::chrono::steady_clock::now() >= end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

}  // namespace burnish::testing
