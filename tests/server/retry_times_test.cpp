#include "server/jobs/retry_times.h"

#include <gtest/gtest.h>

namespace burnish {
namespace {

using namespace std::chrono_literals;

const auto kNow = RetryTimes::Clock::time_point() + 1h;

TEST(RetryTimes, AreAJobApart) {
  RetryTimes times;
  EXPECT_EQ(times.next(kNow, 8s, 4), 8s);
  EXPECT_EQ(times.next(kNow, 8s, 4), 10s);
  EXPECT_EQ(times.next(kNow + 1s, 8s, 4), 11s) << "from the moment of asking";
}

TEST(RetryTimes, AreNeverBeforeTheJobsAtHandAreDone) {
  RetryTimes times;
  EXPECT_EQ(times.next(kNow, 2s, 1), 2s);
  EXPECT_EQ(times.next(kNow + 10s, 5s, 5), 5s) << "the times before have passed";
  EXPECT_EQ(times.next(kNow + 10s, 9s, 9), 9s);
  EXPECT_EQ(times.next(kNow + 30s, 0s, 0), 0s);
}

TEST(RetryTimes, AreAMinuteAwayAtMost) {
  RetryTimes times;
  for (int i = 0; i < 100; ++i) EXPECT_LE(times.next(kNow, 2s, 1), 1min);
  EXPECT_EQ(times.next(kNow, 2s, 1), 1min) << "some never come back";
  EXPECT_EQ(times.next(kNow, 5min, 3), 1min);
}

/// Of two callers, after 64 were taken, `refused` of them after a refusal.
double gap_after(RetryTimes& times, int refused) {
  for (int i = 0; i < refused; ++i) times.next(kNow, 0s, 64);
  for (int i = 0; i < 64; ++i) times.count_taken();
  RetryTimes look = times;
  const auto first = look.next(kNow, 64ms, 64);
  return std::chrono::duration<double, std::milli>(look.next(kNow, 64ms, 64) - first).count();
}

TEST(RetryTimes, AreSpreadWhileManyAreRefusedAndDrawnTogetherAgain) {
  RetryTimes times;
  EXPECT_EQ(gap_after(times, 16), 1) << "a quarter";
  EXPECT_EQ(gap_after(times, 17), 2);
  EXPECT_EQ(gap_after(times, 17), 4);
  EXPECT_EQ(gap_after(times, 17), 4) << "no farther";
  EXPECT_EQ(gap_after(times, 4), 4) << "a sixteenth";
  EXPECT_EQ(gap_after(times, 3), 2);
  EXPECT_EQ(gap_after(times, 0), 1);
  EXPECT_EQ(gap_after(times, 0), 1) << "no closer";
}

}  // namespace
}  // namespace burnish
