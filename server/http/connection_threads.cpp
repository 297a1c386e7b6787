#include "server/http/connection_threads.h"

#include <chrono>
#include <system_error>
#include <utility>

namespace burnish {
namespace {

constexpr std::chrono::seconds kIdleFor{5};

}  // namespace

ConnectionThreads::~ConnectionThreads() {
  std::unique_lock lock(mutex_);
  stopping_ = true;
  work_comes_.notify_all();
  work_ends_.wait(lock, [this] { return threads_.empty(); });
  lock.unlock();
  for (std::thread& thread : ended_) thread.join();
}

bool ConnectionThreads::run(Work work) {
  Threads ended;
  bool taken = false;
  {
    const std::lock_guard lock(mutex_);
    ended.swap(ended_);
    taken = busy_ < most_ && (work_.size() < idle_ || add_thread());
    if (taken) {
      ++busy_;
      work_.push_back(std::move(work));
      work_comes_.notify_one();
    }
  }
  for (std::thread& thread : ended) thread.join();
  return taken;
}

bool ConnectionThreads::add_thread() {
  const auto self = threads_.emplace(threads_.end());
  try {
    *self = std::thread([this, self] { serve(self); });
    return true;
  } catch (const std::system_error&) {
    threads_.erase(self);
    return false;
  }
}

void ConnectionThreads::serve(Threads::iterator self) {
  std::unique_lock lock(mutex_);
  while (true) {
    ++idle_;
    work_comes_.wait_for(lock, kIdleFor, [this] { return stopping_ || !work_.empty(); });
    --idle_;
    if (work_.empty()) break;
    Work work = std::move(work_.front());
    work_.pop_front();
    lock.unlock();
    work();
    work = {};
    lock.lock();
    --busy_;
    work_ends_.notify_all();
  }
  // Joined by the next one that ends: a thread that nobody joined keeps its stack.
  Threads before;
  before.swap(ended_);
  ended_.splice(ended_.end(), threads_, self);
  work_ends_.notify_all();
  lock.unlock();
  for (std::thread& thread : before) thread.join();
}

std::size_t ConnectionThreads::busy() const {
  const std::lock_guard lock(mutex_);
  return busy_;
}

bool ConnectionThreads::wait_until_idle(std::chrono::milliseconds patience) const {
  std::unique_lock lock(mutex_);
  return work_ends_.wait_for(lock, patience, [this] { return busy_ == 0; });
}

}  // namespace burnish
