#include "core/run/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

namespace burnish {
namespace {

TEST(ParallelFor, VisitsEveryItemOnceForAnyThreadCount) {
  for (const unsigned threads : {1U, 2U, 7U, 0U}) {
    std::vector<std::atomic<int>> visits(10 * kBlockSize + 17);
    EXPECT_TRUE(parallel_for(visits.size(), {.threads = threads}, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) ++visits[i];
    }));
    for (const auto& count : visits) ASSERT_EQ(count, 1) << threads;
  }
}

TEST(ParallelFor, StopsBetweenBlocks) {
  for (const unsigned threads : {1U, 2U}) {
    std::stop_source source;
    std::atomic<std::size_t> blocks = 0;
    EXPECT_FALSE(parallel_for(100 * kBlockSize, {.stop = source.get_token(), .threads = threads},
                              [&](std::size_t, std::size_t) {
                                if (++blocks == 3) source.request_stop();
                                // Whoever is ahead of the one that stops must not run on meanwhile.
                                while (blocks >= 3 && !source.stop_requested()) std::this_thread::yield();
                              }));
    EXPECT_LE(blocks, 3U + threads);
  }
}

TEST(ParallelFor, StopsWhenTheDeadlineHasPassed) {
  const RunControl run{.deadline = RunControl::Clock::now() - std::chrono::seconds(1)};
  EXPECT_FALSE(parallel_for(kBlockSize, run, [](std::size_t, std::size_t) { FAIL(); }));
  EXPECT_EQ(run.check().error().cause, Cause::DeadlineExceeded);
}

TEST(ParallelSum, GivesTheSameBitsForAnyThreadCount) {
  const auto sum = [](unsigned threads) {
    return parallel_sum(50'000, {.threads = threads}, [](std::size_t begin, std::size_t end) {
      double s = 0;
      for (std::size_t i = begin; i < end; ++i) s += 1.0 / static_cast<double>(i + 1);
      return s;
    });
  };
  EXPECT_EQ(sum(1), sum(2));
  EXPECT_EQ(sum(1), sum(8));
}

TEST(Cause, HasACodeOfItsOwn) {
  for (const Cause a : all_causes()) {
    for (const Cause b : all_causes()) EXPECT_EQ(a == b, cause_code(a) == cause_code(b));
  }
}

}  // namespace
}  // namespace burnish
