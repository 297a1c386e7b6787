// One thread per connection: made when a connection needs it, used again, ended when idle.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <list>
#include <mutex>
#include <thread>

namespace burnish {

class ConnectionThreads {
 public:
  using Work = std::function<void()>;

  explicit ConnectionThreads(std::size_t most) : most_(most) {}
  ~ConnectionThreads();  ///< waits for all work
  ConnectionThreads(const ConnectionThreads&) = delete;
  ConnectionThreads& operator=(const ConnectionThreads&) = delete;

  /// Runs it at once on a thread of its own; `work` must not throw. False, and nothing happens, when `most`
  /// are busy or the system gives no more threads.
  bool run(Work work);

  std::size_t busy() const;
  /// True as soon as none is busy; false when some still are at the end of `patience`.
  bool wait_until_idle(std::chrono::milliseconds patience) const;

 private:
  using Threads = std::list<std::thread>;
  bool add_thread();
  void serve(Threads::iterator self);

  const std::size_t most_;
  mutable std::mutex mutex_;  ///< guards everything below
  mutable std::condition_variable work_comes_, work_ends_;
  std::deque<Work> work_;  ///< never more than threads that are about to take it
  Threads threads_, ended_;
  std::size_t idle_ = 0, busy_ = 0;
  bool stopping_ = false;
};

}  // namespace burnish
