#include "server/lifecycle.h"

namespace burnish {
namespace {

bool legal(LifecycleState from, LifecycleState to) {
  switch (to) {
    case LifecycleState::Starting:
      return false;
    case LifecycleState::Serving:
      return from == LifecycleState::Starting;
    case LifecycleState::Draining:
      return from == LifecycleState::Starting || from == LifecycleState::Serving;
    case LifecycleState::Stopped:
      return from == LifecycleState::Starting || from == LifecycleState::Draining;
  }
  return false;
}

}  // namespace

std::string_view lifecycle_name(LifecycleState state) {
  switch (state) {
    case LifecycleState::Starting:
      return "starting";
    case LifecycleState::Serving:
      return "serving";
    case LifecycleState::Draining:
      return "draining";
    case LifecycleState::Stopped:
      return "stopped";
  }
  return "unknown";
}

bool Lifecycle::move_to(LifecycleState next) {
  LifecycleState now = state();
  while (legal(now, next)) {
    if (state_.compare_exchange_weak(now, next)) return true;
  }
  return false;
}

}  // namespace burnish
