#include "server/grpc/timer.h"

#include <utility>

namespace burnish {

void Timer::set(std::chrono::milliseconds delay, std::function<void()> fire) {
  // A fresh alarm each time: one that is just calling back must not be set again before it returned.
  alarm_ = std::make_unique<grpc::Alarm>();
  alarm_->Set(std::chrono::system_clock::now() + delay, [fire = std::move(fire)](bool passed) {
    if (passed) fire();
  });
}

}  // namespace burnish
