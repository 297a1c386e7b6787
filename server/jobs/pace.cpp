#include "server/jobs/pace.h"

#include <algorithm>

namespace burnish {
namespace {

constexpr double kNewest = 0.2;  // share of the newest job in the average

}  // namespace

void Pace::learn(double work, std::chrono::duration<double> took) {
  if (work <= 0) return;
  const double measured = took.count() / work;
  // The first job of a process is slow (cold caches), so the average starts there and follows.
  seconds_per_work_ = known_ ? seconds_per_work_ + kNewest * (measured - seconds_per_work_) : measured;
  known_ = true;
}

std::optional<std::chrono::duration<double>> Pace::expect(double work) const {
  if (!known_) return {};
  return std::chrono::duration<double>(seconds_per_work_ * std::max(work, 0.0));
}

}  // namespace burnish
