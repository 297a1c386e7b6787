#include "server/jobs/job_runner.h"

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
using testing::Ending;
using testing::Gate;
using testing::GatedJob;

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
