// What a JobRunner takes and what it refuses, and when who is refused may come back.
#include "server/jobs/job_runner.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <future>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "tests/server/gate.h"
#include "tests/support/eventually.h"

namespace burnish {
namespace {

using namespace std::chrono_literals;
using Clock = RunControl::Clock;
using testing::Ending;
using testing::Gate;
using testing::GatedJob;
using ::testing::HasSubstr;

TEST(JobRunner, RefusesWhatTheMemoryOfTheJobsAtHandLeavesNoRoomFor) {
  Gate gate;
  GatedJob large, second, small;
  JobRunner runner({.workers = 1, .queue = 8, .max_memory = 1000});
  ASSERT_TRUE(runner.submit(large.work(gate), {.bytes = 700}, {}).ok());
  const auto refused = runner.submit(second.work(gate), {.bytes = 301}, {});
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().cause, Cause::MemoryFull);
  EXPECT_THAT(refused.error().message, HasSubstr("(max-memory)"));
  ASSERT_TRUE(runner.submit(small.work(gate), {.bytes = 300}, {}).ok());
  EXPECT_EQ(runner.reserved_bytes(), 1000u);
  gate.open();
  EXPECT_EQ(large.end.get(), Ending());
  EXPECT_EQ(small.end.get(), Ending());
  EXPECT_TRUE(testing::eventually([&] { return runner.reserved_bytes() == 0; }));
  EXPECT_TRUE(runner.would_take({.bytes = 1000}, {}).ok());
}

TEST(JobRunner, SaysThatAJobWhichNeedsMoreThanAllMemoryIsTooLarge) {
  JobRunner runner({.workers = 1, .max_memory = 1000});
  const auto refused = runner.would_take({.bytes = 1001}, {});
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().cause, Cause::TooLarge);
  EXPECT_THAT(refused.error().message, HasSubstr("(max-memory)"));
}

TEST(JobRunner, GivesBackTheMemoryOfJobsThatNeverRan) {
  Gate gate;
  GatedJob running, cancelled;
  JobRunner runner({.workers = 1, .queue = 4, .max_memory = 1000});
  ASSERT_TRUE(runner.submit(running.work(gate), {.bytes = 1}, {}).ok());
  gate.wait_for(1);
  auto handle = runner.submit(cancelled.work(gate), {.bytes = 999}, {});
  ASSERT_TRUE(handle.ok());
  handle->cancel();
  EXPECT_EQ(runner.reserved_bytes(), 1u);
  gate.open();
  EXPECT_EQ(running.end.get(), Ending());
}

/// A runner with one busy worker that has learned that a unit of work takes `per_work` or a little more.
struct BusyRunner {
  explicit BusyRunner(std::chrono::milliseconds per_work, std::size_t queue = 8,
                      std::chrono::seconds queue_seconds = {})
      : runner({.workers = 1, .queue = queue, .queue_seconds = queue_seconds}) {
    std::promise<void> learned;
    constexpr std::chrono::milliseconds kLong{
        200};  // so that a moment's pause of the machine is a small part
    const auto take_a_while = [&](const RunControl&, double) {
      const auto end = Clock::now() + kLong;
      testing::eventually([end] { return Clock::now() >= end; });
      learned.set_value();
    };
    const double work = static_cast<double>(kLong / per_work);
    EXPECT_TRUE(runner.submit({take_a_while, [](const Error&) {}}, {.work = work}, {}).ok());
    learned.get_future().wait();
    EXPECT_TRUE(testing::eventually([this] { return runner.running() == 0; }));
    EXPECT_TRUE(runner.submit(running.work(gate), {.work = 1000}, {}).ok());
    gate.wait_for(1);
  }
  ~BusyRunner() { gate.open(); }

  Gate gate;
  GatedJob running;
  JobRunner runner;
};

TEST(JobRunner, RefusesADeadlineThatTheJobsAtHandLeaveNoTimeFor) {
  BusyRunner busy(20ms);  // the job that runs is expected to take 20 s
  const auto soon = busy.runner.would_take({.work = 1}, Clock::now() + 2s);
  ASSERT_FALSE(soon.ok());
  EXPECT_EQ(soon.error().cause, Cause::DeadlineExceeded);
  EXPECT_TRUE(busy.runner.would_take({.work = 1}, Clock::now() + 10min).ok());
  EXPECT_TRUE(busy.runner.would_take({.work = 1}, {}).ok());
}

TEST(JobRunner, RefusesADeadlineThatTheJobItselfCannotMeet) {
  BusyRunner busy(20ms);
  EXPECT_FALSE(busy.runner.would_take({.work = 1e6}, Clock::now() + 10min).ok()) << "it takes hours";
}

TEST(JobRunner, TellsWhenAPlaceIsExpectedByTheWorkOfTheJobsAtHand) {
  BusyRunner busy(20ms, 0);
  const auto full = busy.runner.would_take({.work = 1}, {});
  ASSERT_FALSE(full.ok());
  EXPECT_EQ(full.error().cause, Cause::QueueFull);
  EXPECT_GE(full.error().retry_after, 15s);
  EXPECT_LE(full.error().retry_after, 1min);
}

TEST(JobRunner, GivesEveryRefusedCallerATimeOfItsOwnAndSpreadsThemWhileMostAreRefused) {
  Gate gate;
  std::vector<GatedJob> running(4);
  JobRunner runner({.workers = 4, .queue = 64});  // no job has run: each is expected to take a second
  for (GatedJob& job : running) ASSERT_TRUE(runner.submit(job.work(gate), {.work = 1}, {}).ok());
  gate.wait_for(4);
  std::vector<JobHandle> waiting;
  const auto fill = [&] {
    for (JobHandle& job : std::exchange(waiting, {})) job.cancel();
    const JobWork idle{.run = [](const RunControl&, double) {}, .refuse = [](const Error&) {}};
    for (int i = 0; i < 64; ++i) waiting.push_back(runner.submit(idle, {.work = 1}, {}).value());
  };
  const auto retry = [&] { return runner.would_take({.work = 1}, {}).error().retry_after; };
  const auto twenty_more = [&] {
    const auto one = retry();
    for (int i = 1; i < 20; ++i) retry();
    return std::chrono::duration<double>(retry() - one).count();
  };
  fill();
  const double apart = twenty_more();  // a quarter of a second each, less what passed meanwhile
  EXPECT_NEAR(apart, 5, 1.2);
  fill();
  EXPECT_NEAR(twenty_more() / apart, 2, 0.5);
  gate.open();
}

TEST(JobRunner, GivesNoTimesToKeptJobsThatAskForMemory) {
  Gate gate;
  GatedJob running;
  JobRunner runner({.workers = 1, .queue = 0, .max_memory = 1000});
  ASSERT_TRUE(runner.submit(running.work(gate), {.bytes = 500, .work = 1}, {}).ok());
  gate.wait_for(1);
  const auto retry = [&] { return runner.would_take({.work = 1}, {}).error().retry_after; };
  const auto first = retry();
  for (int i = 0; i < 20; ++i) {
    const auto asked = runner.would_take({.bytes = 600}, {}, {}, true);
    ASSERT_FALSE(asked.ok());
    EXPECT_EQ(asked.error().cause, Cause::MemoryFull);
  }
  EXPECT_LT(retry(), first + 5s);
  gate.open();
  EXPECT_EQ(running.end.get(), Ending());
}

/// Runs one after the other what waits behind `busy` and gives the order in which they came.
struct Order {
  std::mutex mutex;
  std::vector<std::string> names;

  JobWork work(const std::string& name, const Turn& turn, bool kept = false) {
    return {.run =
                [this, name](const RunControl&, double) {
                  const std::lock_guard lock(mutex);
                  names.push_back(name);
                },
            .refuse = [](const Error&) {},
            .turn = turn,
            .kept = kept};
  }
};

TEST(JobRunner, GivesOwnersTheirTurnsAndWhatIsLowTheLast) {
  Order order;
  BusyRunner busy(1ms, 16);
  const auto submit = [&](const std::string& name, const Turn& turn) {
    EXPECT_TRUE(busy.runner.submit(order.work(name, turn), {.work = 1}, {}).ok()) << name;
  };
  submit("low", {.low = true});
  for (const char* name : {"a1", "a2", "a3"}) submit(name, {.owner = "a"});
  submit("b1", {.owner = "b"});
  busy.gate.open();
  busy.runner.drain(10s);
  EXPECT_EQ(order.names, (std::vector<std::string>{"a1", "b1", "a2", "a3", "low"}));
}

TEST(JobRunner, LeavesPlacesOfTheQueueToOtherOwners) {
  Order order;
  BusyRunner busy(1ms, 8);
  const auto submit = [&](const std::string& owner) {
    return busy.runner.submit(order.work(owner, {.owner = owner}), {.work = 1}, {});
  };
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(submit("greedy").ok()) << i;
  const auto refused = submit("greedy");
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().cause, Cause::QueueFull);
  EXPECT_GT(refused.error().retry_after, 0ms);
  EXPECT_TRUE(submit("modest").ok());
  BusyRunner alone(1ms, 8);
  for (int i = 0; i < 8; ++i)
    EXPECT_TRUE(alone.runner.submit(order.work("all", {}), {.work = 1}, {}).ok()) << "nobody else has tokens";
}

TEST(JobRunner, BoundsTheTimeThatTheJobsAtHandAreExpectedToTake) {
  Order order;
  JobRunner fast({.workers = 1, .queue_seconds = 1s});
  EXPECT_TRUE(fast.would_take({.work = 1e9}, {}).ok()) << "nothing waits for it";
  BusyRunner busy(20ms, 8, 30s);  // the job that runs is expected to take 20 s
  EXPECT_TRUE(busy.runner.would_take({.work = 100}, {}).ok());
  const auto long_one = busy.runner.would_take({.work = 1000}, {});
  ASSERT_FALSE(long_one.ok());
  EXPECT_EQ(long_one.error().cause, Cause::QueueFull);
  EXPECT_THAT(long_one.error().message, HasSubstr("(queue-seconds)"));
  EXPECT_TRUE(busy.runner.would_take({.work = 1000}, {}, {}, true).ok())
      << "kept jobs have a bound of their own";
}

TEST(JobRunner, HasAPlaceForKeptJobsHoweverFullItsQueueIs) {
  Order order;
  BusyRunner busy(1ms, 1);
  EXPECT_TRUE(busy.runner.submit(order.work("waits", {}), {}, {}).ok());
  EXPECT_EQ(busy.runner.would_take({}, {}).error().cause, Cause::QueueFull);
  EXPECT_TRUE(busy.runner.submit(order.work("kept", {}, true), {}, {}).ok());
  busy.gate.open();
  busy.runner.drain(10s);
  EXPECT_EQ(order.names, (std::vector<std::string>{"waits", "kept"}));
}

TEST(JobRunner, KeepsTheMemoryFreeThatAKeptJobWaitsFor) {
  Gate gate;
  GatedJob half, small;
  JobRunner runner({.workers = 2, .queue = 8, .max_memory = 1000});
  ASSERT_TRUE(runner.submit(half.work(gate), {.bytes = 500}, {}).ok());
  EXPECT_EQ(runner.would_take({.bytes = 800}, {}, {}, true).error().cause, Cause::MemoryFull);
  EXPECT_EQ(runner.submit(small.work(gate), {.bytes = 300}, {}).error().cause, Cause::MemoryFull);
  gate.open();
  EXPECT_EQ(half.end.get(), Ending());
  ASSERT_TRUE(testing::eventually([&] { return runner.reserved_bytes() == 0; }));
  EXPECT_EQ(runner.would_take({.bytes = 300}, {}).error().cause, Cause::MemoryFull) << "it has not come yet";
  Order order;
  EXPECT_TRUE(runner.submit(order.work("large", {}, true), {.bytes = 800}, {}).ok());
  ASSERT_TRUE(testing::eventually([&] { return runner.reserved_bytes() == 0; }));
  EXPECT_TRUE(runner.would_take({.bytes = 300}, {}).ok());
}

}  // namespace
}  // namespace burnish
