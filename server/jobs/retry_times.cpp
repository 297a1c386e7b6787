#include "server/jobs/retry_times.h"

#include <algorithm>
#include <utility>

namespace burnish {
namespace {

constexpr std::chrono::minutes kFarthest{1};
constexpr unsigned kRound = 64;  // taken, between two looks at the spread
constexpr double kMany = 0.25, kFew = 0.0625, kWidest = 4;

}  // namespace

std::chrono::milliseconds RetryTimes::next(Clock::time_point now, Seconds wait, std::size_t jobs) {
  const auto ticks = [](Seconds seconds) { return std::chrono::duration_cast<Clock::duration>(seconds); };
  const Seconds each = wait / static_cast<double>(std::max<std::size_t>(1, jobs));
  last_ = std::max(last_ + ticks(spread_ * each), now + ticks(wait));
  last_ = std::min(last_, now + kFarthest);
  ++refused_;
  return std::chrono::ceil<std::chrono::milliseconds>(last_ - now);
}

void RetryTimes::count_taken() {
  if (++taken_ < kRound) return;
  const double refused = static_cast<double>(std::exchange(refused_, 0)) / std::exchange(taken_, 0);
  if (refused > kMany) spread_ = std::min(kWidest, 2 * spread_);
  if (refused < kFew) spread_ = std::max(1.0, spread_ / 2);
}

}  // namespace burnish
