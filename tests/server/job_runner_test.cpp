#include "server/jobs/job_runner.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <mutex>
#include <stdexcept>

#include "tests/server/gate.h"
#include "tests/support/eventually.h"

namespace burnish {
namespace {

using namespace std::chrono_literals;
using Clock = RunControl::Clock;
using testing::Gate;
using ::testing::HasSubstr;

/// How a job ended: the cause that refused or stopped it, or nothing when it finished.
using Ending = std::optional<Cause>;

/// A job that waits at a gate, and the promise of its end.
struct GatedJob {
  std::promise<Ending> promise;
  std::future<Ending> end = promise.get_future();

  JobWork work(Gate& gate) {
    return {.run =
                [this, &gate](const RunControl& run, double) {
                  promise.set_value(gate.pass(run) ? Ending() : Ending(run.stop_error().cause));
                },
            .refuse = [this](const Error& error) { promise.set_value(error.cause); }};
  }
};

TEST(JobRunner, RefusesWhenFull) {
  Gate gate;
  GatedJob running, waiting, refused;
  JobRunner runner({.workers = 1, .queue = 1});
  ASSERT_TRUE(runner.submit(running.work(gate), {}, {}).ok());
  gate.wait_for(1);
  ASSERT_TRUE(runner.submit(waiting.work(gate), {}, {}).ok());
  const auto third = runner.submit(refused.work(gate), {}, {});
  ASSERT_FALSE(third.ok());
  EXPECT_EQ(third.error().cause, Cause::QueueFull);
  EXPECT_EQ(runner.running(), 1u);
  EXPECT_EQ(runner.queued(), 1u);
  gate.open();
  EXPECT_EQ(running.end.get(), Ending());
  EXPECT_EQ(waiting.end.get(), Ending());
  EXPECT_EQ(refused.end.wait_for(0s), std::future_status::timeout)
      << "submit() said no: no callback may follow";
}

TEST(JobRunner, TakesAJobForAnIdleWorkerEvenWithoutAQueue) {
  Gate gate;
  GatedJob first, second;
  JobRunner runner({.workers = 1, .queue = 0});
  ASSERT_TRUE(runner.submit(first.work(gate), {}, {}).ok());
  EXPECT_EQ(runner.submit(second.work(gate), {}, {}).error().cause, Cause::QueueFull);
  gate.open();
  EXPECT_EQ(first.end.get(), Ending());
}

TEST(JobRunner, RefusesACancelledQueuedJobAtOnce) {
  Gate gate;
  GatedJob running, waiting;
  JobRunner runner({.workers = 1, .queue = 1});
  ASSERT_TRUE(runner.submit(running.work(gate), {}, {}).ok());
  gate.wait_for(1);
  auto handle = runner.submit(waiting.work(gate), {}, {});
  ASSERT_TRUE(handle.ok());
  handle->cancel();
  EXPECT_EQ(waiting.end.get(), Ending(Cause::Cancelled));
  EXPECT_EQ(runner.queued(), 0u);
  handle->cancel();  // safe to repeat
  gate.open();
  EXPECT_EQ(running.end.get(), Ending());
}

TEST(JobRunner, StopsACancelledRunningJob) {
  Gate gate;
  GatedJob job;
  JobRunner runner({.workers = 1});
  auto handle = runner.submit(job.work(gate), {}, {});
  gate.wait_for(1);
  handle->cancel();
  EXPECT_EQ(job.end.get(), Ending(Cause::Cancelled));
}

TEST(JobRunner, RefusesAQueuedJobAtItsDeadlineWhileAllWorkersAreBusy) {
  Gate gate;
  GatedJob running, waiting;
  JobRunner runner({.workers = 1, .queue = 1});
  ASSERT_TRUE(runner.submit(running.work(gate), {}, {}).ok());
  gate.wait_for(1);
  const auto deadline = Clock::now() + 30ms;
  ASSERT_TRUE(runner.submit(waiting.work(gate), {}, deadline).ok());
  EXPECT_EQ(waiting.end.get(), Ending(Cause::DeadlineExceeded));
  EXPECT_GE(Clock::now(), deadline);
  EXPECT_EQ(runner.running(), 1u) << "the worker is still busy";
  gate.open();
  EXPECT_EQ(running.end.get(), Ending());
}

TEST(JobRunner, StopsARunningJobAtItsDeadline) {
  Gate gate;
  GatedJob job;
  JobRunner runner({.workers = 1});
  ASSERT_TRUE(runner.submit(job.work(gate), {}, Clock::now() + 200ms).ok());
  EXPECT_EQ(job.end.get(), Ending(Cause::DeadlineExceeded));
}

TEST(JobRunner, DoesNotRunAJobWhoseDeadlineHasPassed) {
  Gate gate;
  GatedJob job;
  JobRunner runner({.workers = 1});
  ASSERT_TRUE(runner.submit(job.work(gate), {}, Clock::now() - 1s).ok());
  EXPECT_EQ(job.end.get(), Ending(Cause::DeadlineExceeded));
}

TEST(JobRunner, DrainFinishesAcceptedJobsAndRefusesNewOnes) {
  Gate gate;
  GatedJob running, waiting, late;
  JobRunner runner({.workers = 1, .queue = 4});
  ASSERT_TRUE(runner.submit(running.work(gate), {}, {}).ok());
  gate.wait_for(1);
  ASSERT_TRUE(runner.submit(waiting.work(gate), {}, {}).ok());
  auto drained = std::async(std::launch::async, [&] { runner.drain(60s); });
  std::optional<Error> refusal;
  ASSERT_TRUE(testing::eventually([&] {
    const auto result =
        runner.submit({.run = [](const RunControl&, double) {}, .refuse = [](const Error&) {}}, {}, {});
    if (!result) refusal = result.error();
    return refusal && refusal->cause == Cause::ShuttingDown;
  }));
  gate.open();
  drained.get();
  EXPECT_EQ(running.end.get(), Ending());
  EXPECT_EQ(waiting.end.get(), Ending());
}

TEST(JobRunner, EndOfGraceStopsRunningJobsAndRefusesWaitingOnes) {
  Gate gate;
  GatedJob running, waiting;
  JobRunner runner({.workers = 1, .queue = 4});
  ASSERT_TRUE(runner.submit(running.work(gate), {}, {}).ok());
  gate.wait_for(1);
  ASSERT_TRUE(runner.submit(waiting.work(gate), {}, {}).ok());
  runner.drain(10ms);
  EXPECT_EQ(running.end.get(), Ending(Cause::Cancelled));
  EXPECT_EQ(waiting.end.get(), Ending(Cause::ShuttingDown));
}

TEST(JobRunner, ASecondDrainCutsTheGraceShort) {
  Gate gate;
  GatedJob job;
  JobRunner runner({.workers = 1});
  ASSERT_TRUE(runner.submit(job.work(gate), {}, {}).ok());
  gate.wait_for(1);
  auto drained = std::async(std::launch::async, [&] { runner.drain(1h); });
  runner.drain(0ms);
  EXPECT_EQ(job.end.get(), Ending(Cause::Cancelled));
  EXPECT_EQ(drained.wait_for(20s), std::future_status::ready);
}

TEST(JobRunner, GivesAllCoresToAJobThatStartsAloneAndOneOtherwise) {
  Gate gate;
  std::promise<unsigned> first, second;
  JobRunner runner({.workers = 2, .queue = 2, .threads = 7});
  const auto report_threads = [&gate](std::promise<unsigned>& threads) {
    return JobWork{.run =
                       [&](const RunControl& run, double) {
                         threads.set_value(run.threads);
                         gate.pass(run);
                       },
                   .refuse = [](const Error&) {}};
  };
  ASSERT_TRUE(runner.submit(report_threads(first), {}, {}).ok());
  EXPECT_EQ(first.get_future().get(), 7u);
  ASSERT_TRUE(runner.submit(report_threads(second), {}, {}).ok());
  EXPECT_EQ(second.get_future().get(), 1u);
  gate.open();
}

TEST(JobRunner, SurvivesACallbackThatThrows) {
  Gate gate;
  GatedJob after;
  JobRunner runner({.workers = 1, .queue = 2});
  ASSERT_TRUE(runner
                  .submit({.run = [](const RunControl&, double) { throw std::runtime_error("on purpose"); },
                           .refuse = [](const Error&) {}},
                          {}, {})
                  .ok());
  gate.open();
  ASSERT_TRUE(runner.submit(after.work(gate), {}, {}).ok());
  EXPECT_EQ(after.end.get(), Ending());
}

TEST(JobRunner, TellsHowLongAJobWaited) {
  Gate gate;
  GatedJob blocker;
  std::promise<double> waited;
  JobRunner runner({.workers = 1, .queue = 1});
  ASSERT_TRUE(runner.submit(blocker.work(gate), {}, {}).ok());
  gate.wait_for(1);
  const auto queued_at = Clock::now();
  ASSERT_TRUE(runner
                  .submit({.run = [&](const RunControl&, double queue_ms) { waited.set_value(queue_ms); },
                           .refuse = [](const Error&) {}},
                          {}, {})
                  .ok());
  EXPECT_TRUE(testing::eventually([&] { return Clock::now() > queued_at + 20ms; }));
  gate.open();
  EXPECT_GE(waited.get_future().get(), 20.0);
}

TEST(JobRunner, CallsExactlyOneCallbackPerJobUnderStress) {
  constexpr std::size_t kThreads = 4, kJobsPerThread = 500;
  std::vector<std::atomic<int>> calls(kThreads * kJobsPerThread);
  std::atomic<std::size_t> accepted = 0, shut_out = 0;
  JobRunner runner({.workers = 3, .queue = 16});
  const auto submit_one = [&](std::size_t job) {
    auto& count = calls[job];
    std::optional<Clock::time_point> deadline;
    if (job % 3 == 0) deadline = Clock::now() + std::chrono::microseconds(job % 100);
    for (;;) {
      auto handle = runner.submit({.run = [&count](const RunControl&, double) { ++count; },
                                   .refuse = [&count](const Error&) { ++count; }},
                                  {}, deadline);
      if (handle) {
        ++accepted;
        if (job % 2 == 0) handle->cancel();
        return;
      }
      if (handle.error().cause == Cause::ShuttingDown) {
        ++shut_out;
        return;
      }
      std::this_thread::yield();
    }
  };
  {
    std::vector<std::jthread> threads;
    for (std::size_t t = 0; t < kThreads; ++t) {
      threads.emplace_back([&, t] {
        for (std::size_t i = 0; i < kJobsPerThread; ++i) submit_one(t * kJobsPerThread + i);
      });
    }
    ASSERT_TRUE(testing::eventually([&] { return accepted > calls.size() / 2; }));
    runner.drain(1ms);
  }
  EXPECT_EQ(accepted + shut_out, calls.size());
  std::size_t called = 0;
  for (const auto& count : calls) {
    EXPECT_LE(count, 1);
    called += static_cast<std::size_t>(count);
  }
  EXPECT_EQ(called, accepted) << "every accepted job, and no other, has its one callback";
  EXPECT_EQ(runner.queued() + runner.running(), 0u);
}

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
    const auto take_a_while = [&](const RunControl&, double) {
      const auto end = Clock::now() + per_work;
      testing::eventually([end] { return Clock::now() >= end; });
      learned.set_value();
    };
    EXPECT_TRUE(runner.submit({take_a_while, [](const Error&) {}}, {.work = 1}, {}).ok());
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
  Gate gate;
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

TEST(JobRunner, GivesEveryRefusedCallerATurnOfItsOwn) {
  BusyRunner busy(1ms, 0);  // the job that runs is expected to take a second
  const auto turn = [&] { return busy.runner.would_take({.work = 1}, {}).error().retry_after; };
  const auto first = turn(), second = turn(), third = turn();
  EXPECT_GE(second - first, 500ms);
  EXPECT_GE(third - second, 500ms);
  std::chrono::milliseconds last{};
  for (int i = 0; i < 200; ++i) last = turn();
  EXPECT_LE(last, 1min) << "not for ever: some never come back";
}

TEST(JobRunner, SpreadsTheTurnsWhileThoseWhoComeBackFindTheirPlaceTaken) {
  BusyRunner busy(1ms, 64);
  std::vector<JobHandle> waiting;
  const auto fill = [&] {
    for (JobHandle& job : waiting) job.cancel();
    waiting.clear();
    const JobWork idle{.run = [](const RunControl&, double) {}, .refuse = [](const Error&) {}};
    for (int i = 0; i < 64; ++i) waiting.push_back(busy.runner.submit(idle, {.work = 100}, {}).value());
  };
  const auto turn = [&] {
    return std::chrono::duration<double>(busy.runner.would_take({.work = 1}, {}).error().retry_after).count();
  };
  const auto gap = [&] {
    const double one = turn();
    return turn() - one;
  };
  fill();
  const double first = gap();
  const auto gap_after = [&](int refused) {
    for (int i = 0; i < refused; ++i) turn();
    fill();
    return gap() / first;
  };
  EXPECT_NEAR(gap_after(20), 2, 0.5);
  EXPECT_NEAR(gap_after(20), 4, 1);
  EXPECT_NEAR(gap_after(20), 4, 1) << "no further";
  EXPECT_NEAR(gap_after(8), 4, 1) << "few enough";
  EXPECT_NEAR(gap_after(0), 2, 0.5);
  EXPECT_NEAR(gap_after(0), 1, 0.3);
  EXPECT_NEAR(gap_after(0), 1, 0.3) << "no closer";
}

TEST(JobRunner, GivesNoTurnsToKeptJobsThatAskForMemory) {
  Gate gate;
  GatedJob running;
  JobRunner runner({.workers = 1, .queue = 0, .max_memory = 1000});
  ASSERT_TRUE(runner.submit(running.work(gate), {.bytes = 500, .work = 1}, {}).ok());
  gate.wait_for(1);
  const auto turn = [&] { return runner.would_take({.work = 1}, {}).error().retry_after; };
  const auto first = turn();
  for (int i = 0; i < 20; ++i) {
    const auto asked = runner.would_take({.bytes = 600}, {}, {}, true);
    ASSERT_FALSE(asked.ok());
    EXPECT_EQ(asked.error().cause, Cause::MemoryFull);
  }
  EXPECT_LT(turn(), first + 5s);
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

TEST(JobRunner, BoundsEveryRun) {
  Gate gate;
  GatedJob job;
  JobRunner runner({.workers = 1, .longest_run = 20ms});
  ASSERT_TRUE(runner.submit(job.work(gate), {}, {}).ok());
  EXPECT_EQ(job.end.get(), Ending(Cause::DeadlineExceeded));
}

TEST(JobRunner, IsHealthyUntilEveryWorkerIsHeldByAJobThatDoesNotEnd) {
  std::promise<void> let_go;
  const auto blocker = [held = let_go.get_future().share()](const RunControl&, double) { held.wait(); };
  JobRunner runner({.workers = 2, .queue = 8, .longest_run = 1ms, .overrun = 5ms});
  EXPECT_TRUE(runner.healthy());
  ASSERT_TRUE(runner.submit({blocker, [](const Error&) {}}, {}, {}).ok());
  ASSERT_TRUE(testing::eventually([&] { return runner.stuck_workers() == 1; }));
  EXPECT_TRUE(runner.healthy()) << "one worker still turns";
  ASSERT_TRUE(runner.submit({blocker, [](const Error&) {}}, {}, {}).ok());
  EXPECT_TRUE(testing::eventually([&] { return !runner.healthy(); }));
  let_go.set_value();
  EXPECT_TRUE(testing::eventually([&] { return runner.healthy(); })) << "it recovers";
}

TEST(JobRunner, StaysHealthyUnderAFullQueue) {
  Gate gate;
  std::vector<GatedJob> jobs(9);
  JobRunner runner({.workers = 1, .queue = 8});
  for (GatedJob& job : jobs) ASSERT_TRUE(runner.submit(job.work(gate), {}, {}).ok());
  EXPECT_TRUE(runner.healthy());
  gate.open();
  for (GatedJob& job : jobs) EXPECT_EQ(job.end.get(), Ending());
}

}  // namespace
}  // namespace burnish
