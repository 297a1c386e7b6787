#include "core/run/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

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

TEST(BlockSize, GivesTwoOrFourThreadsAsMuchToDo) {
  for (std::size_t items = 1; items < 70 * kBlockSize; items += 1 + items / 50) {
    const std::size_t blocks = block_count(items), size = block_size(items);
    EXPECT_LE(size, kBlockSize);
    EXPECT_GE(blocks * size, items);
    EXPECT_LT((blocks - 1) * size, items) << "an empty block";
    if (items <= kBlockSize) {
      EXPECT_EQ(blocks, 1);
    } else {
      EXPECT_EQ(blocks % 2, 0) << items;
      EXPECT_TRUE(items <= 8 * kBlockSize || blocks % 4 == 0) << items;
      EXPECT_LT(blocks * size - items, blocks) << items;  // the last is as long as the others, or nearly
    }
  }
}

TEST(ParallelFor, GivesEachThreadAShareAndThoseWhoAreDoneTheRestOfAnothersFromItsBack) {
  const std::size_t items = 16 * kBlockSize, blocks = block_count(items);
  const RunControl run{.threads = 2};
  if (thread_count(run) < 2) GTEST_SKIP() << "one core";
  for (int loop = 0; loop < 3; ++loop) {  // the same in every loop
    std::vector<std::size_t> order;       // of the other thread, which is alone while the first block waits
    std::atomic<std::size_t> done = 0;
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    parallel_for(items, run, [&](std::size_t begin, std::size_t) {
      if (begin == 0) {
        while (done < blocks - 1 && std::chrono::steady_clock::now() < until) std::this_thread::yield();
      } else if (done < blocks - 1) {
        order.push_back(begin / block_size(items));
        ++done;
      }
    });
    std::vector<std::size_t> expected;
    for (std::size_t b = blocks / 2; b < blocks; ++b) expected.push_back(b);
    for (std::size_t b = blocks / 2 - 1; b > 0; --b) expected.push_back(b);
    EXPECT_EQ(order, expected);
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
