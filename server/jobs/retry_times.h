// When callers that were refused for want of a place may come back.
#pragma once

#include <chrono>
#include <cstddef>

namespace burnish {

/// Gives every refused caller a time of its own, behind those refused before: all at once they would be
/// refused again. A minute is the farthest, as some never come back. Callers that were served and come again
/// take the places of those that were told to come back, and each of these is a refusal more to pay for: so
/// while more than a quarter as many are refused as taken, times are spread, up to four jobs apart; below a
/// sixteenth they are drawn together again. Not thread-safe.
class RetryTimes {
 public:
  using Clock = std::chrono::steady_clock;
  using Seconds = std::chrono::duration<double>;

  /// From `now`, for one that is refused now; all `jobs` at hand are expected to be done after `wait`.
  std::chrono::milliseconds next(Clock::time_point now, Seconds wait, std::size_t jobs);

  void count_taken();  ///< one that was not refused

 private:
  Clock::time_point last_ = {};
  double spread_ = 1;                 ///< in times of a job
  unsigned taken_ = 0, refused_ = 0;  ///< since spread_ was looked at
};

}  // namespace burnish
