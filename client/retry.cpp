#include "client/retry.h"

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <random>

namespace burnish::client {
namespace {

using std::chrono::milliseconds;

// More than these would overflow the clocks.
constexpr std::chrono::hours kLongestTimeout{24 * 365};  ///< longer ones mean none
constexpr std::chrono::hours kLongestDelay{24};

std::optional<Attempts::Clock::time_point> deadline_after(const std::optional<milliseconds>& timeout) {
  if (!timeout || *timeout > kLongestTimeout) return std::nullopt;
  return Attempts::Clock::now() + std::max(*timeout, milliseconds::zero());
}

double random_fraction() {
  thread_local std::minstd_rand generator(std::random_device{}());
  return std::uniform_real_distribution<double>(0, 1)(generator);
}

bool wait_unless_stopped(milliseconds delay, const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  never.wait_for(lock, stop, delay, [] { return false; });
  return !stop.stop_requested();
}

}  // namespace

bool passes(const Error& error) {
  return error.code == grpc::StatusCode::UNAVAILABLE || error.cause == "queue_full" ||
         error.cause == "memory_full";
}

Attempts::Attempts(const CallOptions& options)
    : options_(options), deadline_(deadline_after(options.timeout)) {}

bool Attempts::again(Error& error) {
  error.attempts = ++made_;
  if (error.code == grpc::StatusCode::CANCELLED && options_.stop.stop_requested()) {
    error.message = "the caller stopped the call";  // gRPC has no word for it
  }
  if (made_ >= options_.retry.attempts || !passes(error)) return false;
  const milliseconds pause = delay(error);
  if (deadline_ && Clock::now() + pause >= *deadline_) return false;
  const auto& wait = options_.retry.wait;
  if (wait ? wait(pause, options_.stop) : wait_unless_stopped(pause, options_.stop)) return true;
  error.code = grpc::StatusCode::CANCELLED;
  error.cause = "cancelled";
  error.message = "stopped while waiting to try again after: " + error.message;
  return false;
}

milliseconds Attempts::delay(const Error& error) {
  const RetryPolicy& policy = options_.retry;
  const auto in_ms = [](milliseconds time) { return static_cast<double>(time.count()); };
  const double grown = in_ms(policy.initial_delay) * std::pow(policy.multiplier, made_ - 1);
  const double ceiling = std::min({grown, in_ms(policy.longest_delay), in_ms(kLongestDelay)});
  const double fraction = policy.jitter ? policy.jitter() : random_fraction();
  // On top of the server's time, or all whom it turned away would come back at once.
  return error.retry_after + milliseconds(static_cast<milliseconds::rep>(std::max(0.0, fraction * ceiling)));
}

}  // namespace burnish::client
